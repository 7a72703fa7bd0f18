"""The clock ports of the bus, looked at for a moment."""

import time
from typing import Any, NamedTuple

from bus import Input, Node
from bus.clock import SILENCE, Clock
from deploy.discovery import all_ports


class Tick(NamedTuple):
    """One message of a clock."""

    arrival: int  # monotonic [ns]
    clock: Clock


def look_at_clocks(node: Node, seconds: float) -> list[dict[str, Any]]:
    """Return ``{port, time [ns], state, rate}`` of each clock, seen for ``seconds`` [s].

    A clock that was silent for 0.5 s is ``absent``; ``rate`` is simulated to wall time.
    """
    names = [port["name"] for port in all_ports(node) if port["type"] == Clock.TYPE]
    names = [name for name in names if name.endswith(":o")]
    inputs = [
        node.input(f"/{node.name}/clock{number}:i", Clock, source=name, depth=4096)
        for number, name in enumerate(names)
    ]
    end = time.monotonic() + seconds if inputs else 0.0
    while node.running and (remaining := end - time.monotonic()) > 0:
        node.wait(min(remaining, 0.1))
    return [_row(name, _ticks(entry)) for name, entry in zip(names, inputs, strict=True)]


def _ticks(entry: Input) -> list[Tick]:
    ticks = []
    while (received := entry.read()) is not None:
        ticks.append(Tick(received.arrival, received.data))
    return ticks


def _row(port: str, ticks: list[Tick]) -> dict[str, Any]:
    if not ticks or time.monotonic_ns() - ticks[-1].arrival > SILENCE * 1e9:
        return {"port": port, "time": None, "state": "absent", "rate": None}
    first, last = ticks[0], ticks[-1]
    elapsed = last.arrival - first.arrival
    rate = (last.clock.time - first.clock.time) / elapsed if elapsed else None
    return {"port": port, "time": last.clock.time, "state": last.clock.state, "rate": rate}
