"""Bytes to messages: checks types, shapes, numbers and size, and never executes anything."""

import dataclasses
from collections.abc import Mapping
from copy import copy
from typing import Any, NamedTuple

import msgpack
import numpy as np

from bus.envelope import Envelope
from bus.errors import WireError
from bus.head import INT64, NUMBERS, TAGS, UINT64, pack_block_head, pack_prefix
from bus.layout import CACHE_SIZE, FLOAT64, Plan, Shapes, read_layout
from bus.packing import pack
from bus.schema import Field, fields_of, type_name

_KINDS = (str, bytes, int, int, int, int, int, int, bool, str, str, dict, tuple, bytes)
_NAMES = (*Envelope._fields, "scalars", "layout", "block")
_BOUND = 1 << 63
_envelope = tuple.__new__


class _Known(NamedTuple):
    """The last message's parts that a next one of the same source is likely to repeat."""

    prefix: bytes
    middle: bytes  # valid, reason, model, scalars, layout, head of the block
    start: int  # of the middle part
    length: int
    head: tuple[str, bytes, int]
    tail: tuple[bool, str, str]
    values: dict[str, Any]
    plan: Plan


class Decoder:
    """Reads messages of one type; raises nothing but WireError."""

    def __init__(
        self, message_type: type, model: str = "", dimensions: Mapping[str, int] | None = None
    ):
        fields = fields_of(message_type)
        self._type = message_type
        self._name = type_name(message_type)
        self._model = model
        self._shapes = Shapes(fields, dimensions or {})
        self._flags = [field for field in fields if field.kind == "flags"]
        self._scalars = [field for field in fields if field.kind == "scalar"]
        self._arrays = [field for field in fields if field.kind == "array"]
        self._repeatable = all(field.simple for field in self._scalars)
        flat = self._scalars if self._repeatable else []
        self._lists = [field.name for field in flat if field.annotation.startswith("list")]
        self._plans: dict[bytes, Plan] = {}
        self._known: _Known | None = None
        # a frozen __init__ sets each field by a call of its own, 1 us for a sensor frame
        self._plain = not {"__post_init__", "__slots__"} & set(dir(message_type))

    def decode(self, data: bytes) -> tuple[Any, Envelope]:
        """Return the message and its envelope."""
        try:
            known = self._known
            if known is not None and data.startswith(known.prefix):
                if len(data) == known.length and data.startswith(known.middle, known.start):
                    return self._decode_alike(data, known)
            return self._decode(data)
        except WireError:
            raise
        except Exception as error:  # whatever bytes from outside provoke is a bad message
            raise WireError(f"not a {self._name} message: {error}") from error

    def _decode_alike(self, data: bytes, known: _Known) -> tuple[Any, Envelope]:
        """Decode a message that differs from the last one in its numbers and its block only."""
        numbers = NUMBERS.unpack_from(data, len(known.prefix))
        tag_seq, seq, tag_stamp, stamp, clock, tag_acquired, acquired, tag_sent, sent = numbers
        if (tag_seq, tag_stamp, tag_acquired, tag_sent) != TAGS or clock > 1:
            return self._decode(data)
        parts = (*known.head, seq, stamp, clock, acquired, sent, *known.tail)
        values = known.values.copy()
        for name in self._lists:  # each message has lists of its own
            values[name] = values[name].copy()
        _fill(values, known.plan, data[known.start + len(known.middle) :])
        return self._build(values), _envelope(Envelope, parts)

    def _decode(self, data: bytes) -> tuple[Any, Envelope]:
        parts = msgpack.unpackb(data, use_list=False)
        if type(parts) is not tuple or tuple(map(type, parts)) != _KINDS:
            raise _bad_parts(parts)
        envelope = Envelope._make(parts[:11])
        self._check_envelope(envelope)
        scalars, layout, block = parts[11:]
        plan = self._plans.get(pack(layout)) or self._plan(layout)  # packed, true is not 1
        if len(block) != 8 * plan.size:
            raise WireError(f"block: expected {8 * plan.size} bytes, got {len(block)}")
        constant = self._read_scalars(scalars, plan)
        values = constant.copy()
        for name in self._lists:
            values[name] = values[name].copy()
        _fill(values, plan, block)
        if self._repeatable:
            self._remember(data, envelope, constant, plan)
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
            raise WireError(f"another robot: expected model {self._model}, got {model!r:.20}")

    def _plan(self, layout: tuple) -> Plan:
        plan = self._shapes.plan(read_layout(layout))
        names = {slot.name for slot in plan.slots}
        for field in self._arrays:
            if field.name not in names and not field.optional:
                raise WireError(f"field {field.name}: missing, got {sorted(names)}")
        if len(self._plans) >= CACHE_SIZE:
            self._plans.clear()
        self._plans[pack(layout)] = plan
        return plan

    def _read_scalars(self, scalars: dict, plan: Plan) -> dict[str, Any]:
        """Return everything but the arrays, which are None."""
        values: dict[str, Any] = {field.name: None for field in self._arrays}
        for field in self._scalars:
            given = field.name in scalars
            values[field.name] = field.check(scalars[field.name]) if given else _default(field)
        dimensions = plan.dimensions.copy()
        for field in self._flags:
            flags = _read_flags(field, scalars)
            self._shapes.bind(field, flags.shape, dimensions)
            values[field.name] = flags
        return values

    def _remember(
        self, data: bytes, envelope: Envelope, constant: dict[str, Any], plan: Plan
    ) -> None:
        """Keep the parts that repeat, when the message has the form that our writers give it."""
        prefix = pack_prefix(*envelope[:3])
        start, head = len(prefix) + NUMBERS.size, pack_block_head(8 * plan.size)
        end = len(data) - 8 * plan.size
        if not data.startswith(prefix) or not data[:end].endswith(head):
            return
        numbers = NUMBERS.unpack_from(data, len(prefix))
        if numbers == _interleave(envelope):
            self._known = _Known(
                *(prefix, data[start:end], start, len(data)),
                *(envelope[:3], envelope[8:], constant, plan),
            )

    def _build(self, values: dict[str, Any]) -> Any:
        if not self._plain:
            return self._type(**values)
        message = object.__new__(self._type)
        object.__setattr__(message, "__dict__", values)
        return message


def _fill(values: dict[str, Any], plan: Plan, data: bytes) -> None:
    """Put views of the block into the message's values."""
    plan.check_finite(data)
    block = np.frombuffer(data, FLOAT64)
    for name, part, shape in plan.slots:
        values[name] = block[part] if shape is None else block[part].reshape(shape)


def _interleave(envelope: Envelope) -> tuple[int, ...]:
    seq, stamp, clock, acquired, sent = envelope[3:8]
    return UINT64, seq, INT64, stamp, clock, INT64, acquired, INT64, sent


def _default(field: Field) -> Any:
    if field.default is dataclasses.MISSING:
        raise WireError(f"field {field.name}: missing")
    return copy(field.default)  # a list must not be shared by messages


def _read_flags(field: Field, scalars: dict) -> np.ndarray:
    given = scalars.get(field.name)
    if not isinstance(given, tuple) or not {bool} >= set(map(type, given)):
        raise WireError(f"field {field.name}: expected a list of booleans, got {given!r:.60}")
    flags = np.array(given, dtype=bool)
    flags.flags.writeable = False  # shared by the messages that repeat it
    return flags


def _bad_parts(parts: Any) -> WireError:
    if not isinstance(parts, tuple) or len(parts) != len(_KINDS):
        got = f"{len(parts)} elements" if isinstance(parts, tuple) else type(parts).__name__
        return WireError(f"expected an array of {len(_KINDS)} elements, got {got}")
    for name, value, kind in zip(_NAMES, parts, _KINDS, strict=True):
        if type(value) is not kind:
            return WireError(f"{name}: expected {kind.__name__}, got {value!r:.60}")
    return WireError("bad message")
