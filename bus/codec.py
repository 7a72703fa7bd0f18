"""Messages to bytes and back: one MessagePack array with one block of float64 (docs/wire.md).

``[type, source, epoch, seq, stamp, clock, acquired, sent, valid, reason, model,
scalars, layout, block]``
"""

import dataclasses
from collections.abc import Mapping
from operator import attrgetter
from typing import Any

import msgpack
import numpy as np

from bus.envelope import Envelope
from bus.errors import WireError
from bus.layout import CACHE_SIZE, Plan, Shapes, read_layout
from bus.schema import Field, fields_of, plain, type_name

FLOAT64 = np.dtype("<f8")
_KINDS = (str, bytes, int, int, int, int, int, int, bool, str, str, dict, tuple, bytes)
_ARRAY_OF_14, _BOUND = b"\x9e", 1 << 63


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
        fields = fields_of(message_type)
        self._type = message_type
        self._model = model
        self._shapes = Shapes(fields, dimensions or {})
        self._arrays = _of_kind(fields, "array")
        self._flags = _of_kind(fields, "flags")
        self._scalars = _of_kind(fields, "scalar")
        self._get = _getter([*self._arrays, *self._flags, *self._scalars])
        self._known: dict[tuple, tuple[bytes, bytes, Plan, np.ndarray, bool]] = {}
        self._pack = msgpack.Packer(use_bin_type=True, default=plain).pack
        name = type_name(message_type)
        self._prefix = b"".join((_ARRAY_OF_14, *map(self._pack, (name, source, epoch))))

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
        values = self._get(message)
        count = len(self._arrays)
        middle = count + len(self._flags)
        arrays, flags = values[:count], values[count:middle]
        layout, head, plan, block, whole = self._layout(arrays, flags)
        scalars = {f.name: v.tolist() for f, v in zip(self._flags, flags, strict=True)}
        for field, value in zip(self._scalars, values[middle:], strict=True):
            scalars[field.name] = field.check(value)
        if plan.size:
            present = arrays if whole else [array for array in arrays if array is not None]
            np.concatenate(present, axis=None, out=block, casting="no")
            plan.check_finite(block)
        rest = (seq, stamp, clock, acquired, sent, valid, reason, self._model, scalars)
        return b"".join((self._prefix, self._pack(rest)[1:], layout, head, block.tobytes()))

    def _layout(self, arrays: tuple, flags: tuple) -> tuple[bytes, bytes, Plan, np.ndarray, bool]:
        try:
            shapes = tuple([None if a is None else (a.shape, a.dtype.char) for a in arrays])
            key = (shapes, tuple([(flag.shape, flag.dtype.char) for flag in flags]))
        except AttributeError:
            raise self._not_arrays(arrays, flags) from None
        known = self._known.get(key)
        return known if known is not None else self._plan(key, arrays, flags)

    def _plan(self, key: tuple, arrays: tuple, flags: tuple):
        layout = []
        for field, array in zip(self._arrays, arrays, strict=True):
            if array is not None:
                _check_dtype(field, array, "d")
                layout.append((field.name, array.shape))
            elif not field.optional:
                raise WireError(f"field {field.name}: expected an array, got None")
        plan = self._shapes.plan(layout)
        for field, flag in zip(self._flags, flags, strict=True):
            _check_dtype(field, flag, "?")
            self._shapes.bind(field, flag.shape, plan.dimensions)
        if len(self._known) >= CACHE_SIZE:
            self._known.clear()
        packed = self._pack([[name, *shape] for name, shape in layout])
        head = msgpack.Packer(use_bin_type=True).pack(bytes(8 * plan.size))[
            : -8 * plan.size or None
        ]
        block = np.empty(plan.size, FLOAT64)
        self._known[key] = packed, head, plan, block, len(layout) == len(arrays)
        return self._known[key]

    def _not_arrays(self, arrays: tuple, flags: tuple) -> WireError:
        for field, value in zip([*self._arrays, *self._flags], [*arrays, *flags], strict=True):
            if value is not None and not isinstance(value, np.ndarray):
                return WireError(f"field {field.name}: expected a NumPy array, got {value!r:.60}")
            if value is None and not field.optional:
                return WireError(f"field {field.name}: expected an array, got None")
        return WireError("expected NumPy arrays")


class Decoder:
    """Reads messages of one type; checks everything and raises nothing but WireError."""

    def __init__(
        self, message_type: type, model: str = "", dimensions: Mapping[str, int] | None = None
    ):
        fields = fields_of(message_type)
        self._type = message_type
        self._name = type_name(message_type)
        self._model = model
        self._shapes = Shapes(fields, dimensions or {})
        self._flags = _of_kind(fields, "flags")
        self._scalars = _of_kind(fields, "scalar")
        self._arrays = {field.name: field for field in fields if field.kind == "array"}
        self._defaults = {f.name: f.default for f in fields if f.kind == "array"}
        self._plans: dict[tuple, Plan] = {}
        self._direct = not hasattr(message_type, "__post_init__") and not hasattr(
            message_type, "__slots__"
        )

    def decode(self, data: bytes) -> tuple[Any, Envelope]:
        """Return the message and its envelope."""
        try:
            return self._decode(data)
        except WireError:
            raise
        except Exception as error:  # whatever bytes from outside provoke is a bad message
            raise WireError(f"not a {self._name} message: {error}") from error

    def _decode(self, data: bytes) -> tuple[Any, Envelope]:
        parts = msgpack.unpackb(data, use_list=False)
        if type(parts) is not tuple or tuple(map(type, parts)) != _KINDS:
            raise _bad_parts(parts)
        envelope = Envelope._make(parts[:11])
        self._check_envelope(envelope)
        scalars, layout, block = parts[11:]
        plan = self._plans.get(layout) or self._plan(layout)
        if len(block) != 8 * plan.size:
            raise WireError(f"block: expected {8 * plan.size} bytes, got {len(block)}")
        values = self._values(plan, np.frombuffer(block, FLOAT64))
        self._read_scalars(scalars, plan, values)
        return self._build(values), envelope

    def _check_envelope(self, envelope: Envelope) -> None:
        name, source, epoch, seq, stamp, clock, acquired, sent, _, _, model = envelope
        if name != self._name:
            raise WireError(f"expected type {self._name}, got {name:.60}")
        if len(source) != 16 or not 0 <= epoch < 1 << 32 or seq < 0 or clock not in (0, 1):
            raise WireError(f"bad envelope: {source=!r:.60} {epoch=} {seq=} {clock=}")
        if stamp >= _BOUND or acquired >= _BOUND or sent >= _BOUND:
            raise WireError(f"bad times in the envelope: {stamp=} {acquired=} {sent=}")
        if self._model and model != self._model:
            raise WireError(
                f"another robot's message: expected model {self._model}, got {model!r:.20}"
            )

    def _plan(self, layout: tuple) -> Plan:
        plan = self._shapes.plan(read_layout(layout))
        names = {slot.name for slot in plan.slots}
        for name, field in self._arrays.items():
            if name not in names and not field.optional and field.default is dataclasses.MISSING:
                raise WireError(f"field {name}: missing, got {sorted(names)}")
        if len(self._plans) >= CACHE_SIZE:
            self._plans.clear()
        self._plans[layout] = plan
        return plan

    def _values(self, plan: Plan, block: np.ndarray) -> dict[str, Any]:
        plan.check_finite(block)
        values = self._defaults.copy()
        for name, part, shape in plan.slots:
            values[name] = block[part] if shape is None else block[part].reshape(shape)
        return values

    def _read_scalars(self, scalars: dict, plan: Plan, values: dict[str, Any]) -> None:
        for field in self._scalars:
            value = scalars.get(field.name, _MISSING)
            values[field.name] = field.check(value) if value is not _MISSING else _default(field)
        bound = None
        for field in self._flags:
            flags = np.array(scalars.get(field.name))
            if flags.dtype != bool:
                flags = _flags(field, scalars)
            if flags.shape != (plan.dimensions.get(field.shape[0]),):
                bound = plan.dimensions.copy() if bound is None else bound
                self._shapes.bind(field, flags.shape, bound)
            values[field.name] = flags

    def _build(self, values: dict[str, Any]) -> Any:
        if not self._direct:
            return self._type(**values)
        message = object.__new__(self._type)
        # the frozen __init__ sets each field by a call of its own, 1 us for a sensor frame
        object.__setattr__(message, "__dict__", values)
        return message


_MISSING = object()


def _default(field: Field) -> Any:
    if field.default is dataclasses.MISSING:
        raise WireError(f"field {field.name}: missing")
    return field.default


def _flags(field: Field, scalars: dict) -> np.ndarray:
    if field.name not in scalars and field.default is not dataclasses.MISSING:
        return np.asarray(field.default, dtype=bool)
    if scalars.get(field.name) == ():
        return np.zeros(0, dtype=bool)
    raise WireError(f"field {field.name}: expected booleans, got {scalars.get(field.name)!r:.60}")


def _of_kind(fields: tuple[Field, ...], kind: str) -> tuple[Field, ...]:
    return tuple(field for field in fields if field.kind == kind)


def _getter(fields: list[Field]) -> Any:
    names = [field.name for field in fields]
    if len(names) > 1:
        return attrgetter(*names)
    return lambda message: tuple(getattr(message, name) for name in names)


def _check_dtype(field: Field, array: np.ndarray, char: str) -> None:
    if array.dtype.char != char:
        expected = {"d": "float64", "?": "bool"}[char]
        raise WireError(f"field {field.name}: expected {expected}, got {array.dtype}")


def _bad_parts(parts: Any) -> WireError:
    if not isinstance(parts, tuple) or len(parts) != len(_KINDS):
        got = f"{len(parts)} elements" if isinstance(parts, tuple) else type(parts).__name__
        return WireError(f"expected an array of {len(_KINDS)} elements, got {got}")
    names = (*Envelope._fields, "scalars", "layout", "block")
    for name, value, kind in zip(names, parts, _KINDS, strict=True):
        if type(value) is not kind:
            return WireError(f"{name}: expected {kind.__name__}, got {value!r:.60}")
    return WireError("bad message")
