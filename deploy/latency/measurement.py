"""Round trips through the bus and through Zenoh alone, by turns in the same two processes."""

import subprocess
import time
from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

from bus import Node
from bus.child import command
from deploy.distribution import distribution, quantile
from deploy.latency.askers import Asker, PortAsker, RawAsker

TURNS = 4  # blocks of each, one after the other: both see the same load
WARM_UP = 50  # round trips
TIMEOUT = 1.0  # [s]
Trips = dict[str, list[float | None]]


def measure(node: Node, size: int, rate: float, seconds: float) -> dict[str, Any]:
    """Return round trips [s] of payloads of ``size`` [bytes], paced at ``rate`` [Hz].

    Each of the two is measured for ``seconds`` [s]; Zenoh alone carries messages as long
    as the bus's, envelope included.
    """
    with _echo(node):
        port = PortAsker(node, size)
        raw = RawAsker(node.session, node.name, port.message_size)
        trips = _by_turns(node, {"bus": port, "zenoh": raw}, rate, seconds)
        raw.close()
    result = {"size": 8 * (size // 8), "message_bytes": port.message_size, "rate": rate}
    return result | {name: _summary(values) for name, values in trips.items()}


def _by_turns(node: Node, askers: dict[str, Asker], rate: float, seconds: float) -> Trips:
    trips: Trips = {name: [] for name in askers}
    for asker in askers.values():
        _paced(node, asker, WARM_UP, rate)
    for _ in range(TURNS):
        for name, asker in askers.items():
            trips[name] += _paced(node, asker, max(1, round(rate * seconds / TURNS)), rate)
    return trips


def _paced(node: Node, asker: Asker, count: int, rate: float) -> list[float | None]:
    trips, due = [], time.perf_counter()
    while len(trips) < count and node.running:
        trips.append(asker.trip(TIMEOUT))
        due = max(due + 1.0 / rate, time.perf_counter())
        time.sleep(max(due - time.perf_counter(), 0.0))
    return trips


def _summary(trips: list[float | None]) -> dict[str, Any]:
    came = sorted(trip for trip in trips if trip is not None)
    result = {"count": len(trips), "lost": len(trips) - len(came), **distribution(came)}
    return result | {"p99_9": quantile(came, 0.999)}


@contextmanager
def _echo(node: Node) -> Iterator[None]:
    """Run the other process."""
    where = ["--connect", node.endpoint, "--namespace", node.namespace, "--asker", node.name]
    echo = command("deploy.latency.echo", *where)
    process = subprocess.Popen(echo, start_new_session=True)
    try:
        yield
    finally:
        process.terminate()
        try:
            process.wait(3.0)
        except subprocess.TimeoutExpired:
            process.kill()
            process.wait()
