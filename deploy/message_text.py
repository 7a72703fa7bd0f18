"""Text to messages: a JSON object of fields, or ``KEY=VALUE ...``."""

import json
import shlex
from typing import Any

import numpy as np

from bus.described_type import build, is_array
from bus.names import did_you_mean
from deploy.arguments import arguments
from deploy.errors import UsageError


def read_fields(texts: list[str]) -> dict[str, Any]:
    """Return the fields of a message that is written as words on a command line or as one line.

    Raises:
        UsageError: It is neither a JSON object nor ``KEY=VALUE ...``.
    """
    if len(texts) == 1 and texts[0].lstrip().startswith("{"):
        return _read_json(texts[0])
    if len(texts) == 1:
        texts = _words(texts[0])
    return arguments(texts)


def _words(line: str) -> list[str]:
    try:
        return shlex.split(line)
    except ValueError as error:
        raise UsageError(f"expected KEY=VALUE ..., got {line.strip()!r:.80}: {error}") from None


def _read_json(text: str) -> dict[str, Any]:
    try:
        return json.loads(text)  # it begins as an object: it is one or fails
    except ValueError as error:
        raise UsageError(f"bad JSON {text.strip()!r:.80}: {error}") from None


class Composer:
    """Makes messages of the type that a port told.

    A line as ``read --json`` prints it, with ``data``, is taken too, so that a
    recorded stream can be written again.
    """

    def __init__(self, type_name: str, fields: list[dict[str, Any]], description: str = ""):
        self.type = build(type_name, fields, description)
        self._name = type_name
        self._fields = {entry["name"]: entry for entry in fields}

    def compose(self, values: dict[str, Any]) -> Any:
        """Return a message.

        Raises:
            UsageError: A field is missing, unknown, or no array of numbers.
        """
        if "data" not in self._fields and isinstance(values.get("data"), dict):
            values = values["data"]
        for name in values:
            if name not in self._fields:
                near = did_you_mean(name, self._fields)
                raise UsageError(f"{self._name} has no field {name}{near}; {self._existing()}")
        for name, entry in self._fields.items():
            if name not in values and entry.get("required", not entry["optional"]):
                raise UsageError(f"field {name}: missing; {self._existing()}")
        return self.type(**{name: self._value(name, given) for name, given in values.items()})

    def _value(self, name: str, given: Any) -> Any:
        entry = self._fields[name]
        if entry["type"] == "bytes" and isinstance(given, str):
            return _bytes(name, given)
        if given is None or not is_array(entry):
            return given
        kind = "numbers" if entry["type"] == "float64" else "booleans"
        try:
            array = np.array(given)
        except ValueError:
            array = np.array(None)
        if array.size and array.dtype.kind not in {"numbers": "fiu", "booleans": "b"}[kind]:
            shape = ", ".join(map(str, entry["shape"]))
            raise UsageError(f"field {name}: expected {kind} shaped ({shape}), got {given!r:.60}")
        return _in_shape(array, entry["shape"]).astype(entry["type"])

    def _existing(self) -> str:
        told = [f"{name} ({_describe(entry)})" for name, entry in self._fields.items()]
        return f"its fields are: {', '.join(told) or 'none'}"


def _in_shape(array: np.ndarray, declared: list[int | str]) -> np.ndarray:
    """Return an empty list as the empty array that was meant: text has one for all shapes."""
    sizes = [0 if isinstance(d, str) else d for d in declared]
    return array.reshape(sizes) if array.shape == (0,) and 0 in sizes else array


def _bytes(name: str, given: str) -> bytes:
    try:
        return bytes.fromhex(given)
    except ValueError:
        raise UsageError(f"field {name}: expected hex digits, got {given!r:.60}") from None


def _describe(entry: dict[str, Any]) -> str:
    shape = f"[{', '.join(map(str, entry['shape']))}]" if entry["shape"] else ""
    unit = f" {entry['unit']}" if entry["unit"] else ""
    return f"{entry['type']}{shape}{unit}"
