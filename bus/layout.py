"""How the arrays of a message lie in its block, worked out once per set of shapes."""

import math
from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

import numpy as np

from bus.errors import WireError
from bus.schema import Field

MAX_DIMENSION = 65536  # of a dimension that the description does not fix
MAX_VALUES = 524288  # float64 values in one block, 4 MiB
CACHE_SIZE = 64  # shapes remembered per port; types without fixed shapes must not fill memory

LARGE = 32768  # bytes of a block from which on NumPy's check is the faster one

Shape = tuple[int, ...]
FLOAT64 = np.dtype("<f8")


class Slot(NamedTuple):
    """Where one array lies: its slice of the block, and its shape when it has several axes."""

    name: str
    part: slice
    shape: Shape | None


class Plan(NamedTuple):
    """A checked layout; ``finite`` and its bytes ``mask`` are the scratch of the finite check."""

    slots: tuple[Slot, ...]
    size: int
    dimensions: dict[str, int]
    finite: np.ndarray
    mask: bytearray

    def check_finite(self, block: bytes) -> None:
        """Raise when the block holds NaN or infinity, naming the array.

        NumPy, which is slow when its code is cold, looks only at what may be neither.
        """
        if len(block) <= LARGE:
            top = block[7::8]  # sign and exponent; 7f and ff are those of 2^1009 and more
            if 0x7F not in top and 0xFF not in top:
                return
        self._check_numbers(np.frombuffer(block, FLOAT64))

    def check_arrays(self, arrays: Iterable[np.ndarray]) -> None:
        """Do the same for the arrays that will be the block."""
        if not all(np.isfinite(array).all() for array in arrays):
            self._check_numbers(np.concatenate([array.ravel() for array in arrays]))

    def _check_numbers(self, block: np.ndarray) -> None:
        np.isfinite(block, self.finite)  # with a search in bytes a third of isfinite().all()
        if 0 in self.mask:
            where = self.mask.index(0)
            name = next(slot.name for slot in self.slots if slot.part.stop > where)
            raise WireError(f"field {name}: expected finite numbers, got {block[where]}")


class Shapes:
    """Checks shapes against the declared ones; symbols are bound by ``dimensions`` or by use."""

    def __init__(self, fields: Iterable[Field], dimensions: Mapping[str, int]):
        self._fields = {field.name: field for field in fields}
        self._dimensions = dict(dimensions)

    def plan(self, layout: Iterable[tuple[str, Shape]]) -> Plan:
        """Return the plan of ``(name, shape)`` pairs; arrays of unknown names are skipped."""
        slots, offset, seen = [], 0, set()
        dimensions = dict(self._dimensions)
        for name, shape in layout:
            if name in seen:
                raise WireError(f"field {name}: twice in the layout")
            seen.add(name)
            size = math.prod(shape)
            field = self._fields.get(name)
            if field is not None:
                self.bind(field, shape, dimensions)
                part = slice(offset, offset + size)
                slots.append(Slot(name, part, shape if len(shape) != 1 else None))
            offset += size
            if offset > MAX_VALUES:
                raise WireError(f"layout of more than {MAX_VALUES} values")
        mask = bytearray(offset)
        return Plan(tuple(slots), offset, dimensions, np.frombuffer(mask, dtype=bool), mask)

    def bind(self, field: Field, shape: Shape, dimensions: dict[str, int]) -> None:
        """Check one shape; a symbol met for the first time is bound in ``dimensions``."""
        expected = field.shape
        if len(shape) != len(expected):
            raise self._refuse(field, shape, dimensions)
        for symbol, size in zip(expected, shape, strict=True):
            bound = symbol if isinstance(symbol, int) else dimensions.setdefault(symbol, size)
            if size != bound or size > MAX_DIMENSION:
                raise self._refuse(field, shape, dimensions)

    def _refuse(self, field: Field, shape: Any, dimensions: Mapping[str, int]) -> WireError:
        expected = tuple(dimensions.get(d, d) if isinstance(d, str) else d for d in field.shape)
        declared = "" if expected == field.shape else f" ({', '.join(map(str, field.shape))})"
        got = tuple(shape)
        return WireError(f"field {field.name}: expected shape {expected}{declared}, got {got}")


def read_layout(layout: Any) -> list[tuple[str, Shape]]:
    """Return the decoded layout table as pairs, or raise when it is not one."""
    if not isinstance(layout, tuple):
        raise WireError(f"layout: expected a list, got {layout!r:.60}")
    pairs = []
    for entry in layout:
        if not isinstance(entry, tuple) or not entry or type(entry[0]) is not str:
            raise WireError(f"layout: expected [name, dim, ...], got {entry!r:.60}")
        if any(type(size) is not int or not 0 <= size <= MAX_DIMENSION for size in entry[1:]):
            raise WireError(f"layout of {entry[0]:.60}: bad dimensions {entry[1:]!r:.60}")
        pairs.append((entry[0], entry[1:]))
    return pairs
