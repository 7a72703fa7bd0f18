"""What exists on the bus, for verbs that take a name."""

import time
from typing import Any

from bus import BusError, Node
from bus.introspection import hear_all, list_ports, wait_for_port, wait_for_service
from bus.names import did_you_mean
from deploy.errors import UsageError

SIMULATOR = "/sim/rpc:i"
DEADLINE = 3.0  # [s]


def all_ports(node: Node) -> list[dict[str, Any]]:
    """Return the ports that stand, as soon as no more of them turn up."""
    hear_all(node, timeout=DEADLINE)
    return list_ports(node, settle=0.0)


def is_there(node: Node, name: str) -> bool:
    """Whether a port stands (``/name:o``) or a service is ready (``name``) at this moment."""
    if name.startswith("/"):
        return node.directory.owner(name) is not None
    return any(owner.service == name for owner in node.directory.services())


def are_connected(node: Node, source: str, sink: str) -> bool:
    """Whether an input reads an output at this moment, and both stand."""
    reader = node.directory.owner(sink)
    return is_there(node, source) and reader is not None and source in reader.sources


def require_port(node: Node, name: str) -> None:
    """Make sure that a port stands.

    Raises:
        UsageError: There is no such port; near names are suggested.
    """
    hear_all(node, lambda: is_there(node, name), timeout=DEADLINE)
    try:
        wait_for_port(node, name, timeout=0.0)
    except BusError as error:
        raise UsageError(str(error)) from None


def require_service(node: Node, name: str) -> dict[str, Any]:
    """Return ``{service, host, pid}`` of a service that is ready.

    Raises:
        UsageError: There is none; near names are suggested, and those that exist.
    """
    hear_all(node, lambda: is_there(node, name), timeout=DEADLINE)
    if is_there(node, name) and not name.startswith("/"):
        return wait_for_service(node, name, timeout=0.0)
    ready = sorted({owner.service for owner in node.directory.services()})
    hint = did_you_mean(name, ready)
    raise UsageError(f"no service {name}{hint}; ready are: {', '.join(ready) or 'none'}")


def require_rpc_port(node: Node, name: str) -> None:
    """Make sure that an RPC port stands.

    Raises:
        UsageError: There is no such port, or it is none that can be asked.
    """
    require_port(node, name)
    token = node.directory.owner(name)
    if token is not None and token.direction != "rpc":
        own = f"/{token.owner.service}/rpc:i"
        raise UsageError(f"{name} is an {token.direction}, expected an RPC port such as {own}")


def rpc_port(node: Node, name: str) -> str:
    """Return the RPC port of a service, or the name itself when it is a port's.

    Raises:
        UsageError: There is no such service or RPC port.
    """
    if name.startswith("/"):
        require_rpc_port(node, name)
        return name
    require_service(node, name)
    return f"/{name}/rpc:i"


def _simulators(node: Node) -> list[str]:
    """RPC ports of all simulated robots; on a busy machine the first may be long in coming."""
    deadline = time.monotonic() + DEADLINE
    while True:
        found = [port["name"] for port in all_ports(node) if port["name"].endswith(SIMULATOR)]
        if found or time.monotonic() > deadline or not node.running:
            return found


def simulator_port(node: Node, robot: str | None) -> str:
    """Return the RPC port of the simulated robot: the one named, or the only one alive."""
    found = _simulators(node)
    robots = [name.removeprefix("/").removesuffix(SIMULATOR) for name in found]
    if robot is None and len(found) == 1:
        return found[0]
    if robot in robots:
        return f"/{robot}{SIMULATOR}"
    alive = ", ".join(robots) or "none"
    if robot is None:
        raise UsageError(f"which robot? simulated robots alive: {alive}; say --robot NAME")
    raise UsageError(f"no simulated robot {robot}; alive: {alive}{did_you_mean(robot, robots)}")
