"""``wrenchbus read``, ``hz``: what flows through a port."""

import time
from collections.abc import Iterator
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deploy.options import Json, Seconds, on_the_bus
from deploy.output import print_json, print_line, print_table

if TYPE_CHECKING:
    from bus import Input, Node, Received

DEPTH = 4096  # messages; a slow terminal must not look like a loss
Port = Annotated[str, typer.Argument(help="Port, as /icub/torques:o.")]


@on_the_bus
def read(
    node: "Node",
    port: Port,
    count: Annotated[int | None, typer.Option("-n", "--count", min=1, help="Stop after N.")] = None,
    seconds: Seconds = None,
    as_json: Json = False,
) -> None:
    """Print the messages of a port; Ctrl-C ends it."""
    show = _show_json if as_json else _show
    for number, received in enumerate(messages(node, _open(node, port), seconds), start=1):
        show(port, received)
        if number == count:
            break


@on_the_bus
def hz(
    node: "Node",
    port: Port,
    seconds: Annotated[float, typer.Option(min=0.1, help="How long to measure.")] = 3.0,
    as_json: Json = False,
) -> None:
    """Measure the rate of a port, its jitter and its losses."""
    entry = _open(node, port)
    arrivals = [received.arrival for received in messages(node, entry, seconds)]
    result = {"port": port, **rate(arrivals), "received": len(arrivals)}
    result["lost"] = entry.statistics.lost
    if as_json:
        print_json(result)
    else:
        print_table([result], list(result))


def messages(node: "Node", entry: "Input", seconds: float | None) -> "Iterator[Received]":
    """Yield what arrives until ``seconds`` [s] have passed, or until Ctrl-C."""
    end = float("inf") if seconds is None else time.monotonic() + seconds
    while node.running and (remaining := end - time.monotonic()) > 0:
        node.wait(min(remaining, 0.1))
        while node.running and (received := entry.read()) is not None:
            yield received


def rate(arrivals: list[int]) -> dict[str, float | None]:
    """Return rate [Hz] and periods [s] of monotonic arrival times [ns]."""
    if len(arrivals) < 2:
        return {"hz": 0.0, "period_p50": None, "period_p99": None, "period_max": None}
    periods = sorted(1e-9 * (b - a) for a, b in zip(arrivals, arrivals[1:], strict=False))
    return {
        "hz": len(periods) / sum(periods),
        "period_p50": periods[len(periods) // 2],
        "period_p99": periods[min(int(0.99 * len(periods)), len(periods) - 1)],
        "period_max": periods[-1],
    }


def _open(node: "Node", port: str) -> "Input":
    from deploy.message_type import message_type_of

    return node.input(f"/{node.name}/read:i", message_type_of(node, port), source=port, depth=DEPTH)


def _fields(received: "Received") -> dict[str, Any]:
    return {name: getattr(received.data, name) for name in received.data.__dataclass_fields__}


def _show_json(port: str, received: "Received") -> None:
    envelope = received.envelope._asdict()
    print_json({"port": port, "envelope": envelope, "data": _fields(received)})


def _show(port: str, received: "Received") -> None:
    envelope = received.envelope
    state = "valid" if envelope.valid else f"INVALID: {envelope.reason}"
    age = 1e-6 * (time.time_ns() - envelope.acquired)
    print_line(
        f"{port} seq {envelope.seq} stamp {1e-9 * envelope.stamp:.6f} s {age:.1f} ms {state}"
    )
    for name, field in received.data.__dataclass_fields__.items():
        unit = field.metadata.get("unit", "")
        label = f"{name} [{unit}]" if unit else name
        print_line(f"  {label}: {_plain(getattr(received.data, name))}")


def _plain(value: Any) -> str:
    if not hasattr(value, "tolist"):
        return str(value)
    import numpy as np

    shape = "" if value.ndim < 2 else f"{value.shape} "
    flat = np.array2string(value.ravel(), precision=4, max_line_width=10**6, threshold=48)
    return shape + flat
