"""What the owner of a port tells about the messages that it carries."""

from typing import Any

from bus import BusError, Node
from bus.introspection import port_info
from deploy.discovery import require_port
from deploy.errors import CommandError, UsageError


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
