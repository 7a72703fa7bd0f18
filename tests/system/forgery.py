"""Messages built from a port's public description and docs/wire.md, right and wrong ones."""

import struct
import time
from collections.abc import Mapping
from typing import Any

import msgpack

Info = Mapping[str, Any]
OF_TYPE = {"bool": True, "int": 1, "float": 0.0, "str": "position", "list": [], "dict": {}}


def message(info: Info, dimensions: Mapping[str, int], model: str, **changes: Any) -> bytes:
    """Return a message for a port; ``value`` fills arrays, ``extra`` lengthens the first axis."""
    sizes: dict[Any, int] = {
        **dimensions,
        **{letter: 2 for letter in "cdps" if letter not in dimensions},
    }
    value, extra = changes.get("value", 0.0), changes.get("extra", 0)
    scalars: dict[str, Any] = {}
    layout: list[list[Any]] = []
    count = 0
    for field in info["fields"]:
        shape = [sizes.get(dim, dim) for dim in field["shape"]]
        if field["type"] == "float64":
            shape[0] += extra
            layout.append([field["name"], *shape])
            count += _product(shape)
        elif field["type"] == "bool" and shape:
            scalars[field["name"]] = [True] * (shape[0] + extra)
        else:
            scalars[field["name"]] = changes.get("scalar", _scalar(field["type"]))
    block = struct.pack(f"<{count}d", *[value] * count)
    now = time.time_ns()
    type_name = changes.get("type", info["type"])
    head = [type_name, bytes(16), 0, 1, 1, 0, now, now, True, "", model]
    packed = msgpack.packb([*head, scalars, layout, block])
    assert packed is not None
    return packed


def bad_messages(info: Info, dimensions: Mapping[str, int], model: str) -> dict[str, bytes]:
    """Return what every port must refuse, by name."""
    right = message(info, dimensions, model)
    bad = {
        "nothing": b"",
        "garbage": b"\x00\xff\xc1 garbage " * 9,
        "a truncated message": right[: len(right) // 2],
        "a message and more": right + b"\x00",
        "another type": message(info, dimensions, model, type="Nonsense/1"),
        "an oversized message": right + bytes(200_000),
    }
    shapes = [field["shape"] for field in info["fields"] if field["type"] == "float64"]
    if shapes:
        bad["numbers that are none"] = message(info, dimensions, model, value=float("nan"))
        bad["infinity"] = message(info, dimensions, model, value=float("inf"))
        if any(isinstance(dim, int) or dim in dimensions for shape in shapes for dim in shape[:1]):
            bad["wrong shapes"] = message(info, dimensions, model, extra=1)
    else:
        bad["wrong scalars"] = message(info, dimensions, model, scalar=float("nan"))
    if any("n" in shape for shape in shapes):
        bad["another robot's joints"] = message(info, dimensions, "deadbeef")
    return bad


def _product(shape: list[Any]) -> int:
    result = 1
    for size in shape:
        result *= size
    return result


def _scalar(annotation: str) -> Any:
    kind = annotation.partition("[")[0]
    return OF_TYPE.get(kind, "running")
