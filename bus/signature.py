"""What a verb takes and gives, read from its handler's annotations.

Numbers, booleans, texts, lists, maps, literals, alternatives of these, and dataclasses
whose fields are of these or declared as arrays (`bus.schema`) are checked, on both sides;
whatever else an annotation says is the handler's own business.
"""

import dataclasses
import inspect
import typing
from collections.abc import Callable
from typing import Any

import numpy as np

from bus.errors import WireError
from bus.schema import Check, Field, check_of, fields_of_dataclass


class Contract:
    """The arguments and the answer of one handler."""

    def __init__(self, handler: Callable[..., Any]):
        self._signature = inspect.signature(handler)
        hints = _hints(handler)
        self._answer = hints.pop("return", Any)
        self._checks = {name: typed(hint, name) for name, hint in hints.items()}

    def bind(self, arguments: dict[str, Any]) -> dict[str, Any]:
        """Return the arguments as the handler takes them; raise ValueError saying what it takes."""
        try:
            self._signature.bind(**arguments)
        except TypeError as error:
            raise ValueError(f"{error}; expected {self.usage}") from None
        checks = self._checks
        return {
            name: checks[name](value) if name in checks else value
            for name, value in arguments.items()
        }

    def answer(self, value: Any) -> Any:
        """Return the handler's value as declared; raise WireError when it is something else."""
        return typed(self._answer, "answer")(value)

    @property
    def usage(self) -> str:
        """The arguments in words, as in ``(value, times=1)``."""
        names = [
            name if p.default is p.empty else f"{name}={p.default!r}"
            for name, p in self._signature.parameters.items()
        ]
        return f"({', '.join(names)})"


def typed(hint: Any, name: str) -> Check:
    """Return a function that returns a value in the annotated type, or raises WireError."""
    if dataclasses.is_dataclass(hint) and isinstance(hint, type):
        return _record(hint, name)
    if hint is Any:
        return _anything
    try:
        return check_of(hint, name)
    except TypeError:  # nothing that travels as such
        return _anything


def _hints(handler: Callable[..., Any]) -> dict[str, Any]:
    try:
        return typing.get_type_hints(handler)
    except (NameError, TypeError):  # names that are imported for type checkers only
        return {}


def _anything(value: Any) -> Any:
    return value


def _record(kind: type, name: str) -> Check:
    """Maps with the fields of a dataclass become one."""
    fields = {field.name: field for field in fields_of_dataclass(kind)}

    def check(value: Any) -> Any:
        if isinstance(value, kind):
            return value
        if not isinstance(value, dict) or not fields.keys() >= value.keys():
            expected = f"a map with some of {', '.join(fields)}"
            raise WireError(f"{name}: expected {expected}, got {value!r:.60}")
        given = {key: _read(fields[key], entry) for key, entry in value.items()}
        try:
            return kind(**given)
        except TypeError as error:
            raise WireError(f"{name}: {error}") from None

    return check


def _read(field: Field, value: Any) -> Any:
    if field.kind == "scalar" or (value is None and field.optional):
        return field.check(value)
    try:
        array = np.array(value, dtype=bool if field.kind == "flags" else float)
    except (TypeError, ValueError):
        raise WireError(f"field {field.name}: expected numbers, got {value!r:.60}") from None
    fixed = [d if isinstance(d, int) else size for d, size in zip(field.shape, array.shape)]  # noqa: B905
    if array.ndim != len(field.shape) or fixed != list(array.shape):
        raise WireError(f"field {field.name}: expected shape {field.shape}, got {array.shape}")
    if not np.isfinite(array).all():
        raise WireError(f"field {field.name}: expected finite numbers")
    return array
