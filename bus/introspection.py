"""Who is on the bus, and what the ports are doing."""

import time
from typing import Any

from bus.errors import BusError, RpcError
from bus.information import INFORMATION
from bus.names import did_you_mean, near_names
from bus.node import Node
from bus.rpc import Request, result_of
from bus.tokens import Token

__all__ = [
    "list_ports",
    "list_services",
    "near_names",
    "port_info",
    "wait_for_port",
    "wait_for_service",
]


def list_ports(node: Node, settle: float = 0.2) -> list[dict[str, Any]]:
    """Return all standing ports, sorted by name.

    A node that has just been opened gets ``settle`` seconds to hear from everybody.
    """
    _settle(node, settle)
    return [_entry(token) for token in node.directory.tokens()]


def list_services(node: Node, settle: float = 0.2) -> list[dict[str, Any]]:
    """Return the services that are ready: ``{service, host, pid}``."""
    _settle(node, settle)
    return [
        {"service": owner.service, "host": owner.host, "pid": owner.pid}
        for owner in node.directory.services()
    ]


def port_info(node: Node, name: str, timeout: float = 2.0) -> dict[str, Any]:
    """Return what `list_ports` tells of one port, and its fields, units, frames, statistics."""
    token = wait_for_port(node, name, min(timeout, 1.0))
    key = f"{INFORMATION}/{token.owner.node}"
    request = Request(node.session, key, name.encode(), timeout)
    deadline = time.monotonic() + timeout
    while not request.done and time.monotonic() < deadline:
        request.wait(0.1)
    if not request.done:
        return _entry(token) | {"error": f"no answer within {timeout:g} s; is it stopped?"}
    try:
        return _entry(token) | result_of(request, name, "info", timeout)
    except RpcError as error:
        return _entry(token) | {"error": str(error)}


def wait_for_port(node: Node, name: str, timeout: float = 10.0) -> Token:
    """Return the token of a port as soon as it stands; raise BusError with near names."""
    token = _until(lambda: node.directory.owner(name), timeout)
    if token is None:
        names = node.directory.names()
        raise BusError(f"unknown port {name}{did_you_mean(name, names)}")
    return token


def wait_for_service(node: Node, name: str, timeout: float = 10.0) -> dict[str, Any]:
    """Return ``{service, host, pid}`` as soon as a service is ready; raise BusError after that."""

    def find() -> dict[str, Any] | None:
        found = [entry for entry in list_services(node, 0.0) if entry["service"] == name]
        return found[0] if found else None

    service = _until(find, timeout)
    if service is None:
        ready = [entry["service"] for entry in list_services(node, 0.0)]
        listed = ", ".join(ready) or "none"
        raise BusError(f"service {name} is not ready after {timeout:g} s; ready are: {listed}")
    return service


def _until(find: Any, timeout: float) -> Any:
    deadline = time.monotonic() + timeout
    while (found := find()) is None and time.monotonic() < deadline:
        time.sleep(0.005)
    return found


def _settle(node: Node, seconds: float) -> None:
    remaining = node.opened_at + seconds - time.monotonic()
    if remaining > 0:
        time.sleep(remaining)


def _entry(token: Token) -> dict[str, Any]:
    owner = token.owner
    return {
        "name": token.name,
        "type": token.type,
        "direction": token.direction,
        "owner": {"service": owner.service, "host": owner.host, "pid": owner.pid},
        "nominal_hz": token.rate,
        "sources": list(token.sources),
    }
