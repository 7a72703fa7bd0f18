"""Message types made from what a port tells about itself, so that any port can be read.

No robot package is needed, and a user's own types are read like ours.
"""

import dataclasses
from typing import Any

from bus import BusError, Node
from bus.introspection import port_info
from deploy.annotation import read_annotation
from deploy.discovery import require_port
from deploy.errors import CommandError, UsageError

ARRAYS = ("float64", "bool")


def describe(node: Node, port: str) -> dict[str, Any]:
    """Return what the owner of a port that carries messages tells about it.

    Raises:
        UsageError: There is no such port.
        CommandError: Its owner does not answer, or it carries no messages.
    """
    require_port(node, port)
    try:
        info = port_info(node, port)
    except BusError as error:
        raise CommandError(str(error)) from None
    if "error" in info:
        raise CommandError(f"{port}: {info['error']}")
    if "fields" not in info:
        raise UsageError(f"{port} is an RPC port; ask it with: wrenchbus rpc {port} help")
    return info


def describe_output(node: Node, port: str) -> dict[str, Any]:
    """Return what the owner of an output tells about it.

    Raises:
        UsageError: There is no such port, or it is not an output.
        CommandError: Its owner does not answer.
    """
    info = describe(node, port)
    if info["direction"] == "input":
        sources = ", ".join(info["sources"]) or "no port at present"
        raise UsageError(f"{port} is an input, expected an output; it reads {sources}")
    return info


def build(type_name: str, fields: list[dict[str, Any]]) -> type:
    """Return the dataclass of a type's name and described fields."""
    made = [(entry["name"], _hint(entry), _field(entry)) for entry in fields]
    name = type_name.partition("/")[0]
    return dataclasses.make_dataclass(
        name, made, frozen=True, eq=False, kw_only=True, namespace={"TYPE": type_name}
    )


def is_array(entry: dict[str, Any]) -> bool:
    """Whether a described field is an array of numbers or of flags."""
    return entry["type"] in ARRAYS and bool(entry["shape"])


def _hint(entry: dict[str, Any]) -> Any:
    return Any if is_array(entry) else read_annotation(entry["type"])


def _field(entry: dict[str, Any]) -> Any:
    metadata = {"unit": entry["unit"], "frame": entry["frame"]}
    if is_array(entry):
        metadata |= {"shape": tuple(entry["shape"]), "dtype": entry["type"]}
        metadata |= {"optional": entry["optional"]}
        if not entry["optional"]:
            return dataclasses.field(metadata=metadata)
    return dataclasses.field(metadata=metadata, default=None)  # it may have one and not travel
