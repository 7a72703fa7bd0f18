"""Messages to bytes: one MessagePack array with one block of float64 (docs/wire.md).

``[type, source, epoch, seq, stamp, clock, acquired, sent, valid, reason, model,
scalars, layout, block]``
"""

from collections.abc import Callable, Mapping
from operator import attrgetter
from typing import Any, NamedTuple

import numpy as np

from bus.errors import WireError
from bus.head import INT64, NUMBERS, UINT64, pack_block_head, pack_prefix
from bus.layout import FLOAT64, LARGE, Plan, Shapes
from bus.packing import pack
from bus.schema import Field, fields_of, type_name

_BOOL = np.dtype(bool)


class _Form(NamedTuple):
    """What stays the same while a port's messages keep their shapes and absent fields."""

    get: Callable[[Any], tuple]  # arrays that are there, flags, scalars
    arrays: int
    look: Callable[[Any], tuple]  # shapes and dtypes of arrays and flags, classes of the absent
    seen: tuple
    plan: Plan
    layout: bytes  # packed, with the head of the block


class Encoder:
    """Writes messages of one type from one source."""

    def __init__(
        self,
        message_type: type,
        source: bytes,
        epoch: int = 0,
        model: str = "",
        dimensions: Mapping[str, int] | None = None,
    ):
        self._fields = fields_of(message_type)
        self._type = message_type
        self._model = model
        self._shapes = Shapes(self._fields, dimensions or {})
        self._scalars = [field for field in self._fields if field.kind == "scalar"]
        self._flags = [field for field in self._fields if field.kind == "flags"]
        self._form: _Form | None = None
        self._constant: tuple | None = None  # the last middle part, and what it was made from
        self._middle = b""
        self._comparable = all(field.simple for field in self._scalars)
        self._prefix = pack_prefix(type_name(message_type), source, epoch)

    def encode(
        self,
        message: Any,
        seq: int,
        stamp: int,
        clock: int,
        acquired: int,
        sent: int,
        valid: bool = True,
        reason: str = "",
    ) -> bytes:
        """Return the message as bytes; raise WireError when it breaks its own type."""
        if type(message) is not self._type:
            expected, got = self._type.__name__, type(message).__name__
            raise WireError(f"expected a message of type {expected}, got {got}")
        form, values = self._look(message)
        block = _block(form.plan, values[: form.arrays])
        numbers = NUMBERS.pack(UINT64, seq, INT64, stamp, clock, INT64, acquired, INT64, sent)
        middle = self._pack_middle(form, values[form.arrays :], valid, reason)
        return b"".join((self._prefix, numbers, middle, *block))

    def _look(self, message: Any) -> tuple[_Form, tuple]:
        """Return the form of a message and its values; the form of the last one if it fits."""
        form = self._form
        if form is not None:
            try:
                if form.look(message) == form.seen:
                    return form, form.get(message)
            except AttributeError:
                pass  # a field has become None, or is not an array
        form = self._form = self._new_form(message)
        self._constant = None
        return form, form.get(message)

    def _new_form(self, message: Any) -> _Form:
        layout, absent = [], []
        for field in self._fields:
            value = getattr(message, field.name)
            if field.kind == "array" and value is None and field.optional:
                absent.append(field.name)
            elif field.kind != "scalar":
                _check_array(field, value)
                layout.append((field, value))
        arrays = [(field, value) for field, value in layout if field.kind == "array"]
        flags = [(field, value) for field, value in layout if field.kind == "flags"]
        plan = self._shapes.plan([(field.name, value.shape) for field, value in arrays])
        for field, value in flags:
            self._shapes.bind(field, value.shape, plan.dimensions)
        vectors = [field.name for field, _ in arrays + flags]
        look = _getter(
            *(f"{name}.{what}" for what in ("shape", "dtype") for name in vectors),
            *(f"{name}.__class__" for name in absent),
        )
        table = pack([[field.name, *value.shape] for field, value in arrays])
        return _Form(
            get=_getter(*vectors, *(field.name for field in self._scalars)),
            arrays=len(arrays),
            look=look,
            seen=look(message),
            plan=plan,
            layout=table + pack_block_head(8 * plan.size),
        )

    def _pack_middle(self, form: _Form, values: tuple, valid: bool, reason: str) -> bytes:
        """Pack valid, reason, model, scalars and layout, or take the last ones if equal."""
        count = len(self._flags)
        flags, scalars = values[:count], values[count:]
        constant = None
        if self._comparable and np.ndarray not in map(type, scalars):
            constant = (valid, reason, scalars, _join(flags))
            if constant == self._constant:
                return self._middle
            # copies: the writer may change its own lists in place
            kept = tuple([v.copy() if type(v) is list else v for v in scalars])
            constant = (valid, reason, kept, constant[3])
        table = {f.name: flag.tolist() for f, flag in zip(self._flags, flags, strict=True)}
        for field, value in zip(self._scalars, scalars, strict=True):
            if value is not None or not field.optional:  # else the reader takes its default
                table[field.name] = field.check(value)
        packed = pack((bool(valid), str(reason), self._model, table))
        self._middle = packed[1:] + form.layout
        self._constant = constant
        return self._middle


def _getter(*names: str) -> Callable[[Any], tuple]:
    if len(names) > 1:
        return attrgetter(*names)
    if not names:
        return lambda message: ()
    only = attrgetter(*names)
    return lambda message: (only(message),)


def _block(plan: Plan, arrays: tuple[np.ndarray, ...]) -> tuple[bytes | memoryview, ...]:
    """Return the checked block in pieces; of a large one the arrays themselves, uncopied."""
    if 8 * plan.size <= LARGE:
        block = _join(arrays)
        plan.check_finite(block)
        return (block,)
    plan.check_arrays(arrays)
    return tuple(np.ascontiguousarray(array).data for array in arrays)


def _join(arrays: tuple[np.ndarray, ...]) -> bytes:
    try:
        return b"".join(arrays)  # type: ignore[arg-type]  # they are buffers
    except TypeError:  # one is not contiguous
        return b"".join([array.tobytes() for array in arrays])


def _check_array(field: Field, value: Any) -> None:
    expected = "bool" if field.kind == "flags" else "float64"
    if not isinstance(value, np.ndarray):
        raise WireError(f"field {field.name}: expected a {expected} array, got {value!r:.60}")
    if value.dtype != (_BOOL if field.kind == "flags" else FLOAT64):
        raise WireError(f"field {field.name}: expected {expected}, got {value.dtype}")
