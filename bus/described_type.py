"""Message types made from what a port tells about itself, so that any port can be read.

No robot package is needed, and a user's own types are read like ours.
"""

import dataclasses
from typing import Any

from bus.annotation import read_annotation

ARRAYS = ("float64", "bool")


def build(type_name: str, fields: list[dict[str, Any]], description: str = "") -> type:
    """Return the dataclass of a type's name and described fields; its docstring describes it."""
    made = [(entry["name"], _hint(entry), _field(entry)) for entry in fields]
    name = type_name.partition("/")[0]
    namespace = {"TYPE": type_name, "__doc__": description or f"{name}, as its port describes it."}
    return dataclasses.make_dataclass(
        name, made, frozen=True, eq=False, kw_only=True, namespace=namespace
    )


def is_array(entry: dict[str, Any]) -> bool:
    """Whether a described field is an array of numbers or of flags."""
    return entry["type"] in ARRAYS and bool(entry["shape"])


def _hint(entry: dict[str, Any]) -> Any:
    return Any if is_array(entry) else read_annotation(entry["type"])


def _field(entry: dict[str, Any]) -> Any:
    metadata = {"unit": entry["unit"], "frame": entry["frame"]}
    if not is_array(entry):
        metadata |= {"optional": not entry.get("required", True)}
    else:
        metadata |= {"shape": tuple(entry["shape"]), "dtype": entry["type"]}
        metadata |= {"optional": entry["optional"]}
    if entry.get("required", is_array(entry) and not entry["optional"]):
        return dataclasses.field(metadata=metadata)
    return dataclasses.field(metadata=metadata, default=None)  # it may have one and not travel
