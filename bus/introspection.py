"""Who is on the bus, and what the ports are doing."""

import time
from collections.abc import Callable, Iterable
from typing import Any

from bus.claims import Asker, meet_peers
from bus.envelope import opened_at
from bus.errors import BusError, RpcError
from bus.information import INFORMATION
from bus.names import did_you_mean, near_names
from bus.node import Node
from bus.rpc import Request, result_of
from bus.tokens import Token

__all__ = [
    "hear_all",
    "list_ports",
    "list_services",
    "near_names",
    "port_info",
    "port_infos",
    "wait_for_port",
    "wait_for_service",
]


QUIET = 0.15  # s without news after which everybody has been heard
MISSED = 1.0  # s without news after which what is looked for does not exist
MEET = 2.0  # s


def hear_all(node: Node, found: Callable[[], object] | None = None, timeout: float = 3.0) -> None:
    """Return when ``found()``, or when everybody whom the hub knows has told its ports.

    A node that has just been opened hears from the others one by one, and on a busy
    machine slowly. Raises BusError when no hub answers.
    """
    if found and found():
        return
    quiet = MISSED if found else QUIET
    if time.monotonic() < node.opened_at + MEET:
        meet_peers(node.session, Asker(node.endpoint, MEET, lambda: node.running))
    names, heard, deadline = -1, time.monotonic(), time.monotonic() + timeout
    while node.running and time.monotonic() < min(heard + quiet, deadline):
        if found and found():
            return
        if (now := len(node.directory.names())) != names:
            names, heard = now, time.monotonic()
        time.sleep(0.005)


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
    return _ask([(token, _request(node, token, timeout))], timeout)[0]


def port_infos(node: Node, names: Iterable[str], timeout: float = 2.0) -> list[dict[str, Any]]:
    """Return what `port_info` tells of each port that stands; all are asked at once."""
    tokens = [token for name in names if (token := node.directory.owner(name)) is not None]
    return _ask([(token, _request(node, token, timeout)) for token in tokens], timeout)


def _request(node: Node, token: Token, timeout: float) -> Request:
    key = f"{INFORMATION}/{token.owner.node}"
    return Request(node.session, key, token.name.encode(), timeout)


def _ask(asked: list[tuple[Token, Request]], timeout: float) -> list[dict[str, Any]]:
    deadline = time.monotonic() + timeout
    for _, request in asked:
        while not request.done and (remaining := deadline - time.monotonic()) > 0:
            request.wait(min(remaining, 0.1))
    return [_entry(token) | _told(token, request, timeout) for token, request in asked]


def _told(token: Token, request: Request, timeout: float) -> dict[str, Any]:
    if not request.done:
        return {"error": f"no answer within {timeout:g} s; is it stopped?"}
    try:
        return result_of(request, token.name, "info", timeout)
    except RpcError as error:
        return {"error": str(error)}


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
        "since": opened_at(token.source),  # wall [ns]
        "epoch": token.epoch,
    }
