"""What exists on the bus, for verbs that take a name."""

from bus import BusError, Node
from bus.introspection import list_ports, wait_for_port
from bus.names import did_you_mean
from deploy.errors import UsageError

SIMULATOR = "/sim/rpc:i"


def require_port(node: Node, name: str) -> None:
    """Make sure that a port stands.

    Raises:
        UsageError: There is no such port; near names are suggested.
    """
    try:
        wait_for_port(node, name, timeout=0.5)
    except BusError as error:
        raise UsageError(str(error)) from None


def simulator_port(node: Node, robot: str | None) -> str:
    """Return the RPC port of the simulated robot: the one named, or the only one alive."""
    found = [p["name"] for p in list_ports(node) if p["name"].endswith(SIMULATOR)]
    robots = [name.removeprefix("/").removesuffix(SIMULATOR) for name in found]
    if robot is None and len(found) == 1:
        return found[0]
    if robot in robots:
        return f"/{robot}{SIMULATOR}"
    alive = ", ".join(robots) or "none"
    if robot is None:
        raise UsageError(f"which robot? simulated robots alive: {alive}; say --robot NAME")
    raise UsageError(f"no simulated robot {robot}; alive: {alive}{did_you_mean(robot, robots)}")
