"""The table of inputs: what they missed on the wire, in their queues, and refused."""

from collections.abc import Iterable, Mapping
from typing import Any, NamedTuple

from .html import GREEN, GREY, RED
from .port_rows import counted
from .table import Cell, table

TITLES = ("input", "state", "Hz", "queue", "lost", "dropped", "refused")
NOTE = (
    "Lost: on the wire, counted from the sequence numbers, or seconds late. Dropped: pushed out"
    " of the input's queue by newer messages, which is how a slow reader of &quot;newest&quot;"
    " works. Refused: bad messages. Behind a name: what it reads."
)


class InputRow(NamedTuple):
    """One input port."""

    name: str
    service: str
    sources: tuple[str, ...]
    state: str  # fresh, waiting, stale, "no answer"
    reason: str  # why it is not fresh
    hz: float
    queue: str  # newest, or the length of its FIFO
    lost: int
    dropped: int
    refused: int  # bad ones, and those of who does not own the name


def input_rows(ports: Iterable[Mapping[str, Any]]) -> list[InputRow]:
    """Return a row per input from what the ports tell of themselves (``port_info``)."""
    return [_row(port) for port in ports if port["direction"] == "input"]


def input_table(rows: list[InputRow]) -> str:
    """Return the table."""
    return table("inputs", TITLES, map(_cells, rows), NOTE)


def _row(port: Mapping[str, Any]) -> InputRow:
    count = port.get("statistics", {})
    return InputRow(
        name=port["name"],
        service=port["owner"]["service"],
        sources=tuple(port["sources"]),
        state=_state(port),
        reason=port.get("reason", ""),
        hz=port.get("hz", 0.0),
        queue=_queue(port.get("queue", {})),
        lost=count.get("lost", 0) + count.get("late", 0),
        dropped=count.get("dropped", 0),
        refused=count.get("refused", 0) + count.get("foreign", 0),
    )


def _state(port: Mapping[str, Any]) -> str:
    if "error" in port:
        return "no answer"
    if port.get("fresh"):
        return "fresh"
    # nothing is due on an input without a rate; it waits
    return "stale" if port["nominal_hz"] else "waiting"


def _queue(queue: Mapping[str, Any]) -> str:
    return str(queue["depth"]) if queue.get("mode") == "fifo" else queue.get("mode", "-")


def _cells(row: InputRow) -> list[Cell]:
    return [
        Cell(
            f"{row.name} < {', '.join(row.sources)}" if row.sources else row.name, hint=row.service
        ),
        Cell(row.state, {"fresh": GREEN, "waiting": GREY}.get(row.state, RED), row.reason),
        Cell(f"{row.hz:.0f}"),
        Cell(row.queue),
        counted(row.lost),
        Cell(str(row.dropped)),
        counted(row.refused),
    ]
