"""What a message type declares: its fields, read from a frozen dataclass."""

import dataclasses
import math
import types
import typing
from collections.abc import Callable
from functools import cache
from typing import Any, NamedTuple

import numpy as np

from bus.errors import WireError

Check = Callable[[Any], Any]
_SIMPLE = (bool, int, float, str)


class Field(NamedTuple):
    """One field; ``kind`` is array (float64), flags (bool array) or scalar."""

    name: str
    kind: str
    shape: tuple[str | int, ...]
    optional: bool
    default: Any  # dataclasses.MISSING when it must travel
    check: Check
    annotation: str
    simple: bool  # a scalar that is one bool, int, float or str, or a flat list of them
    unit: str
    frame: str

    def describe(self) -> dict[str, Any]:
        """Return what a user wants to know, as plain values."""
        return {
            "name": self.name,
            "type": {"array": "float64", "flags": "bool"}.get(self.kind, self.annotation),
            "shape": list(self.shape),
            "unit": self.unit,
            "frame": self.frame,
            "optional": self.optional,
            "required": self.default is dataclasses.MISSING and not self.optional,
        }


@cache
def fields_of(message_type: type) -> tuple[Field, ...]:
    """Return the fields of a message type; raise TypeError when it is not one."""
    if not dataclasses.is_dataclass(message_type) or not isinstance(type_name(message_type), str):
        raise TypeError(f"{message_type!r} is not a message: a frozen dataclass with a TYPE text")
    return fields_of_dataclass(message_type)


@cache
def fields_of_dataclass(kind: type) -> tuple[Field, ...]:
    """Return the fields of a message type, or of a part of a request or an answer."""
    hints = typing.get_type_hints(kind)
    return tuple(_field(item, hints[item.name]) for item in dataclasses.fields(kind))


def type_name(message_type: type) -> str:
    """Return name and version, as in ``JointTorques/1``."""
    return getattr(message_type, "TYPE", None)  # type: ignore[return-value]


def _field(item: dataclasses.Field, hint: Any) -> Field:
    metadata = item.metadata
    shape = tuple(metadata.get("shape", ()))
    kind = "scalar"
    if "shape" in metadata:
        kind = "flags" if metadata.get("dtype") == "bool" else "array"
    default = item.default
    if item.default_factory is not dataclasses.MISSING:
        default = item.default_factory()
    return Field(
        name=item.name,
        kind=kind,
        shape=shape,
        optional=bool(metadata.get("optional", False)),
        default=default,
        check=check_of(hint, item.name) if kind == "scalar" else _anything,
        annotation=getattr(hint, "__name__", str(hint)) if _is_plain(hint) else str(hint),
        simple=hint in _SIMPLE or hint in [list[item] for item in _SIMPLE],
        unit=metadata.get("unit", ""),
        frame=metadata.get("frame", ""),
    )


def _is_plain(hint: Any) -> bool:
    return isinstance(hint, type) and not typing.get_args(hint)


def _anything(value: Any) -> Any:
    return value


def check_of(hint: Any, name: str) -> Check:
    """Return a function that returns the value in the annotated type, or raises WireError."""
    origin, arguments = typing.get_origin(hint), typing.get_args(hint)
    if hint is Any:
        return lambda value: plain(value, name)
    if origin in (types.UnionType, typing.Union):
        return _union(arguments, name)
    if origin is typing.Literal:
        return _literal(arguments, name)
    if hint in _SCALARS:
        return _SCALARS[hint](name)
    if (origin or hint) in (list, tuple):
        return _list(check_of(arguments[0] if arguments else Any, name), name)
    if (origin or hint) is dict:
        return _map(check_of(arguments[1] if arguments else Any, name), name)
    raise TypeError(
        f"field {name}: {hint!r} cannot travel; use bool, int, float, str, bytes, list, dict"
    )


def _refuse(name: str, value: Any, expected: str) -> WireError:
    return WireError(f"field {name}: expected {expected}, got {type(value).__name__} {value!r:.60}")


def _exactly(kind: type) -> Callable[[str], Check]:
    def build(name: str) -> Check:
        def check(value: Any) -> Any:
            if type(value) is kind:
                return value
            if isinstance(value, np.generic) and type(value.item()) is kind:
                return value.item()
            raise _refuse(name, value, kind.__name__)

        return check

    return build


def _finite(name: str) -> Check:
    def check(value: Any) -> float:
        if isinstance(value, np.generic):
            value = value.item()
        if type(value) is int:
            value = float(value)
        if type(value) is not float or not math.isfinite(value):
            raise _refuse(name, value, "a finite number")
        return value

    return check


_SCALARS: dict[Any, Callable[[str], Check]] = {
    bool: _exactly(bool),
    int: _exactly(int),
    str: _exactly(str),
    bytes: _exactly(bytes),
    type(None): _exactly(type(None)),
    float: _finite,
}


def _union(arguments: tuple, name: str) -> Check:
    checks = [check_of(argument, name) for argument in arguments]
    expected = " or ".join(getattr(argument, "__name__", str(argument)) for argument in arguments)

    def check(value: Any) -> Any:
        for alternative in checks:
            try:
                return alternative(value)
            except WireError:
                continue
        raise _refuse(name, value, expected)

    return check


def _literal(allowed: tuple, name: str) -> Check:
    def check(value: Any) -> Any:
        for option in allowed:
            if type(value) is type(option) and value == option:
                return value
        raise _refuse(name, value, " or ".join(map(repr, allowed)))

    return check


def _list(item: Check, name: str) -> Check:
    def check(value: Any) -> list:
        if isinstance(value, np.ndarray):
            value = value.tolist()
        if not isinstance(value, list | tuple):
            raise _refuse(name, value, "a list")
        return [item(entry) for entry in value]

    return check


def _map(item: Check, name: str) -> Check:
    def check(value: Any) -> dict:
        if not isinstance(value, dict) or not all(type(key) is str for key in value):
            raise _refuse(name, value, "a map with text keys")
        return {key: item(entry) for key, entry in value.items()}

    return check


def plain(value: Any, name: str = "value") -> Any:
    """Return a value built of None, bool, int, finite float, str, list and dict only.

    Arrays become lists, dataclasses maps.
    """
    if value is None or isinstance(value, bool | int | str) and not isinstance(value, np.generic):
        return value
    if isinstance(value, np.ndarray | np.generic):
        value = value.tolist()
        return plain(value, name)
    if isinstance(value, float):
        if not math.isfinite(value):
            raise _refuse(name, value, "a finite number")
        return float(value)
    if isinstance(value, list | tuple):
        if set(map(type, value)) == {float} and math.isfinite(sum(value)):
            return list(value)  # the common case, without a call for each number
        return [plain(entry, name) for entry in value]
    if isinstance(value, dict):
        return {_text(key, name): plain(entry, name) for key, entry in value.items()}
    if dataclasses.is_dataclass(value) and not isinstance(value, type):
        return {f.name: plain(getattr(value, f.name), name) for f in dataclasses.fields(value)}
    raise _refuse(name, value, "numbers, booleans, texts, lists and maps")


def _text(key: Any, name: str) -> str:
    if type(key) is not str:
        raise _refuse(name, key, "a text as key of a map")
    return key
