"""What can be said of a running bus: hub, services, rates."""

import time
from collections.abc import Iterator
from typing import Any, NamedTuple

from bus import BusError, Node
from bus.introspection import port_info
from deploy.clocks import look_at_clocks
from deploy.discovery import all_ports
from deploy.doctor.pace import LEAST, judge_clock, pace_of, wished_speed
from deploy.doctor.result import Result, fail, ok, warn
from deploy.errors import CommandError
from deploy.options import Connection
from deploy.session import is_told, open_bus
from deploy.verbs.status import services

MEASURE = 1.5  # [s] between two looks at the counters


def live_checks(connection: Connection) -> Iterator[Result]:
    """Yield one result for the hub, one per service, and one per port with a nominal rate."""
    if not is_told(connection):
        yield warn("hub", "no bus runs here; wrenchbus demo starts one")
        return
    try:
        with open_bus(connection) as node:
            yield ok("hub", node.endpoint)
            yield from map(_service, services(node))
            yield from _rates(node)
    except (BusError, CommandError) as error:
        yield fail("hub", str(error))


def _service(row: dict[str, Any]) -> Result:
    name = f"service {row['service']}"
    message = f"{row['state']}, pid {row['pid']}, started again {row['restarts'] or 0} times"
    return ok(name, message) if row["ready"] else fail(name, message)


def _rates(node: Node) -> Iterator[Result]:
    outputs = [p for p in all_ports(node) if p["direction"] == "output" and p["nominal_hz"]]
    before = {port["name"]: _look(node, port["name"]) for port in outputs}
    clocks = look_at_clocks(node, MEASURE)
    time.sleep(0.0 if clocks else MEASURE)
    looks = [(port, before[port["name"]], _look(node, port["name"])) for port in outputs]
    for row in clocks:
        yield judge_clock(row, wished_speed(node, row["port"]))
    for port, first, last in looks:
        yield _rate(port, first, last, pace_of(port["name"], clocks))


class Look(NamedTuple):
    """The counter of an output at one time."""

    time: float  # [s]
    written: int | None  # None: its owner does not answer
    wanted: float  # [Hz]; 0 while nobody listens


def _look(node: Node, name: str) -> Look:
    info = port_info(node, name, timeout=1.0)
    written = info.get("statistics", {}).get("written")
    return Look(time.monotonic(), written, info.get("wanted_hz", info["nominal_hz"]))


def _rate(port: dict[str, Any], before: Look, after: Look, pace: float) -> Result:
    """Compare a port's rate with what its readers want; ``pace`` is simulated to wall time."""
    name = f"port {port['name']}"
    if before.written is None or after.written is None:
        return fail(name, f"its owner {port['owner']['service']} does not answer")
    if before.written == after.written and not after.wanted:
        return ok(name, "silent while nobody listens")
    hz = (after.written - before.written) / (after.time - before.time)
    message = f"{hz:.0f} Hz, nominal {port['nominal_hz']:g} Hz"
    if after.wanted < port["nominal_hz"]:
        message += f", of which its readers want {after.wanted:g} Hz"
    if pace < LEAST:
        message += f", at {pace:.2g} of real time"
    enough = LEAST * pace * min(before.wanted, after.wanted)
    return ok(name, message) if hz >= enough else fail(name, message)
