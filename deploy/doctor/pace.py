"""How fast simulated time goes: rates of what follows a clock are judged by it."""

from typing import Any

from bus import BusError, Node
from deploy.doctor.result import Result, fail, ok, warn

CLOCK, SIMULATOR = "/clock:o", "/sim/rpc:i"
LEAST = 0.9  # of the speed that is wished

Row = dict[str, Any]  # of `look_at_clocks`


def pace_of(port: str, clocks: list[Row]) -> float:
    """Return simulated to wall time where a port's robot has a clock, 1 at most."""
    for row in clocks:
        if port != row["port"] and port.startswith(row["port"].removesuffix(CLOCK) + "/"):
            return min(1.0, row["rate"] or 0.0)
    return 1.0


def wished_speed(node: Node, clock: str) -> float | None:
    """Return what a clock's simulator is set to; None where none answers."""
    port = clock.removesuffix(CLOCK) + SIMULATOR
    try:
        return node.call(port, "param", {"action": "get", "name": "speed"}, timeout=1.0)
    except BusError:
        return None


def judge_clock(row: Row, speed: float | None) -> Result:
    """Tell whether a clock goes, and as fast as is wished."""
    name, rate = f"clock {row['port']}", row["rate"]
    if rate is None:
        return fail(name, f"{row['state']}: nothing comes")
    if row["state"] == "paused":
        return warn(name, "paused; wrenchbus clock resume")
    message = f"{rate:.2g} of real time"
    if speed is not None and rate < LEAST * speed:
        return fail(name, f"{message}, expected {speed:g}: this machine is too slow")
    return ok(name, message) if rate >= LEAST else warn(name, f"{message}: slow motion")
