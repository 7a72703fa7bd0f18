"""Messages as nested maps whose keys are joints, sensors and axes, and their JSON schema."""

import json
from collections.abc import Mapping
from typing import Any

import numpy as np

from bus.described_type import is_array
from bus.envelope import Envelope
from bus.recording import Port
from deploy.recordings.labels import XYZ, Labels, numbers, unique

NAMES = ("limb", "id", "name")  # keys by which lists of maps are told apart


class Keyed:
    """Turns the messages of one port into maps of numbers, booleans, texts and such maps.

    Stamps are seconds. Of covariances only the diagonal is kept, and what is absent is
    left out: no NaN, no null.
    """

    def __init__(self, port: Port, labels: Labels):
        self._fields = port.fields
        self._labels = labels

    def map_of(self, message: Any, envelope: Envelope) -> dict[str, Any]:
        """Return a message as a map."""
        result: dict[str, Any] = {
            "stamp": envelope.stamp * 1e-9,
            "sent": envelope.sent * 1e-9,
            "message_valid": envelope.valid,
            "message_reason": envelope.reason,
        }
        for field in self._fields:
            value = getattr(message, field["name"])
            if value is None:
                continue
            if is_array(field):
                axes = self._labels.of(field, value.shape, message, envelope.model)
                result[field["name"]] = _by_name(field, value, axes)
            else:
                result[field["name"]] = _plain(value, field["type"].startswith("list[str"))
        return result


def _by_name(field: dict[str, Any], value: np.ndarray, axes: list) -> Any:
    if "covariance" in field["name"] and value.ndim >= 2:
        value, axes = np.diagonal(value, axis1=-2, axis2=-1), axes[:-1]
    return _nest(value.tolist(), axes)


def _nest(rows: list, axes: list) -> Any:
    if len(axes) == 1:
        return dict(zip(axes[0], rows, strict=True))
    return {name: _nest(row, axes[1:]) for name, row in zip(axes[0], rows, strict=True)}


def _plain(value: Any, texts: bool = False) -> Any:
    """Turn lists into maps, since readers of JSON plot maps and not lists."""
    if isinstance(value, Mapping):
        return {key: _plain(entry) for key, entry in value.items() if entry is not None}
    if not isinstance(value, list | tuple):
        return value
    if texts or (value and all(isinstance(entry, str) for entry in value)):
        return list(value)
    return dict(zip(_names(value), map(_plain, _diagonal(value)), strict=True))


def _names(value: list | tuple) -> tuple[str, ...]:
    if len(value) == 3 and not isinstance(value[0], Mapping):
        return XYZ
    if value and isinstance(value[0], Mapping):
        for key in NAMES:
            if all(key in entry for entry in value):
                return unique([str(entry[key]) for entry in value])
    return numbers(len(value))


def _diagonal(value: list | tuple) -> list:
    """Of a square matrix only the diagonal is kept."""
    if len(value) > 1 and all(isinstance(row, list) and len(row) == len(value) for row in value):
        return [row[index] for index, row in enumerate(value)]
    return list(value)


def schema_of(port: Port, example: dict[str, Any]) -> bytes:
    """Return a JSON schema for a port's maps.

    It uses no more than Foxglove's reader knows: every map lists its properties, a type is
    one word, and there are no lists of lists.

    Args:
        port: The port.
        example: A message as a map; a key that it lacks may be there in others.
    """
    schema = {"title": port.type, **_schema(example)}
    for field in port.fields:
        if (entry := schema["properties"].get(field["name"])) is not None:
            about = " ".join(
                filter(None, (field["unit"], field["frame"] and f"({field['frame']})"))
            )
            entry |= {"description": about} if about else {}
    for name in ("stamp", "sent"):
        schema["properties"][name]["description"] = "s"
    return json.dumps(schema).encode()


def _schema(value: Any) -> dict[str, Any]:
    if isinstance(value, dict):
        properties = {key: _schema(entry) for key, entry in value.items()}
        return {"type": "object", "properties": properties}
    if isinstance(value, list):
        return {"type": "array", "items": {"type": "string"}}
    if isinstance(value, bool):
        return {"type": "boolean"}
    return {"type": "string" if isinstance(value, str) else "number"}
