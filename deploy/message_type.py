"""Message types made from what a port tells about itself, so that any port can be read.

No robot package is needed, and a user's own types are read like ours.
"""

import dataclasses
from typing import Any

from bus import BusError, Node
from bus.introspection import port_info
from deploy.discovery import require_port
from deploy.errors import CommandError

ARRAYS = ("float64", "bool")


def message_type_of(node: Node, port: str) -> type:
    """Return a frozen dataclass with the fields that the port's owner declares.

    Raises:
        UsageError: There is no such port.
        CommandError: Its owner does not answer, or it carries no messages.
    """
    require_port(node, port)
    try:
        info = port_info(node, port)
    except BusError as error:
        raise CommandError(str(error)) from None
    if "fields" not in info:
        raise CommandError(f"{port} cannot be read: {info.get('error', 'it is an RPC port')}")
    return build(info["type"], info["fields"])


def build(type_name: str, fields: list[dict[str, Any]]) -> type:
    """Return the dataclass of a type's name and described fields."""
    made = [(entry["name"], Any, _field(entry)) for entry in fields]
    name = type_name.partition("/")[0]
    return dataclasses.make_dataclass(
        name, made, frozen=True, eq=False, kw_only=True, namespace={"TYPE": type_name}
    )


def _field(entry: dict[str, Any]) -> Any:
    metadata = {"unit": entry["unit"], "frame": entry["frame"]}
    if entry["type"] in ARRAYS and entry["shape"]:
        metadata |= {"shape": tuple(entry["shape"]), "dtype": entry["type"]}
        metadata |= {"optional": entry["optional"]}
    if entry["optional"]:
        return dataclasses.field(metadata=metadata, default=None)
    return dataclasses.field(metadata=metadata)
