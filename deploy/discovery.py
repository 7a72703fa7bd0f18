"""What exists on the bus, for verbs that take a name."""

import time
from typing import Any

from bus import BusError, Node
from bus.introspection import list_ports, wait_for_port
from bus.names import did_you_mean
from deploy.errors import UsageError

SIMULATOR = "/sim/rpc:i"
QUIET = 0.2  # [s] without news: everybody has been heard
DEADLINE = 3.0  # [s]


def all_ports(node: Node) -> list[dict[str, Any]]:
    """Return the ports that stand, as soon as no more of them turn up.

    A node that has just been opened hears from the others one by one, and on a busy
    machine slowly.
    """
    ports = list_ports(node)
    heard, deadline = time.monotonic(), time.monotonic() + DEADLINE
    while time.monotonic() < min(heard + QUIET, deadline):
        time.sleep(0.02)
        if len(now := list_ports(node)) != len(ports):
            ports, heard = now, time.monotonic()
    return ports


def require_port(node: Node, name: str) -> None:
    """Make sure that a port stands.

    Raises:
        UsageError: There is no such port; near names are suggested.
    """
    try:
        wait_for_port(node, name, timeout=DEADLINE)
    except BusError as error:
        raise UsageError(str(error)) from None


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


def _simulators(node: Node) -> list[str]:
    deadline = time.monotonic() + DEADLINE
    while True:
        found = [p["name"] for p in all_ports(node) if p["name"].endswith(SIMULATOR)]
        if found or time.monotonic() > deadline:
            return found
