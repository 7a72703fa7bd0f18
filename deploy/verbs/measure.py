"""``wrenchbus hz``, ``bw``, ``delay``: how a port's messages flow."""

import time
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deploy.distribution import distribution
from deploy.options import Json, Port, on_the_bus
from deploy.output import print_json, print_line, print_table

if TYPE_CHECKING:
    from bus import Node, Received

Measured = Annotated[float, typer.Option("--seconds", min=0.1, help="How long to measure.")]
UNITS = {"period": "s", "acquired": "s", "sent": "s", "seconds": "s", "size": "B"}
CLOCKS = "ages compare this machine's clock with the writer's: over machines, theirs must agree"


@on_the_bus
def hz(node: "Node", port: Port, seconds: Measured = 3.0, as_json: Json = False) -> None:
    """Measure the rate of a port, its jitter and its losses."""
    from deploy.streams import messages, open_port

    entry = open_port(node, port)
    arrivals = [received.arrival for received in messages(node, entry, seconds)]
    result = {"port": port, **rate(arrivals), "received": len(arrivals)}
    statistics = entry.statistics  # dropped: by us, so that the rate is none of the port's
    _print(result | {"lost": statistics.lost, "dropped": statistics.dropped}, as_json)


@on_the_bus
def bw(node: "Node", port: Port, seconds: Measured = 3.0, as_json: Json = False) -> None:
    """Measure what a port puts on the wire: bytes per second, sizes of messages."""
    from deploy.description import describe_output
    from deploy.payloads import payload_sizes

    describe_output(node, port)
    start = time.monotonic()
    sizes = payload_sizes(node, port, seconds)
    elapsed = time.monotonic() - start
    result = {"port": port, "bytes_per_s": sum(sizes) / elapsed, "hz": len(sizes) / elapsed}
    result |= {"size_min": min(sizes, default=None), **distribution(sizes, "size_")}
    _print(result | {"received": len(sizes), "seconds": elapsed}, as_json)


@on_the_bus
def delay(node: "Node", port: Port, seconds: Measured = 3.0, as_json: Json = False) -> None:
    """Measure how old a port's data are when they arrive: since measured, since sent [s].

    Ages compare clocks: across machines these must agree.
    """
    from deploy.streams import messages, open_port

    ages = [_ages(received) for received in messages(node, open_port(node, port), seconds)]
    since_acquired, since_sent = zip(*ages, strict=True) if ages else ((), ())
    result = {"port": port, **distribution(since_acquired, "acquired_")}
    _print(result | distribution(since_sent, "sent_") | {"received": len(ages)}, as_json)
    if not as_json:
        print_line(CLOCKS)


def rate(arrivals: list[int]) -> dict[str, float | None]:
    """Return rate [Hz] and periods [s] of monotonic arrival times [ns]."""
    periods = [1e-9 * (b - a) for a, b in zip(arrivals, arrivals[1:], strict=False)]
    total = sum(periods)
    return {"hz": len(periods) / total if total else 0.0, **distribution(periods, "period_")}


def _ages(received: "Received") -> tuple[float, float]:
    """Return how long before its arrival a message was measured and sent [s]."""
    arrival = time.time_ns() - (time.monotonic_ns() - received.arrival)
    envelope = received.envelope
    return 1e-9 * (arrival - envelope.acquired), 1e-9 * (arrival - envelope.sent)


def _print(result: dict[str, Any], as_json: bool) -> None:
    if as_json:
        print_json(result)
    else:
        row = {_with_unit(name): value for name, value in result.items()}
        print_table([row], list(row))


def _with_unit(name: str) -> str:
    unit = UNITS.get(name.partition("_")[0])
    return f"{name} [{unit}]" if unit else name
