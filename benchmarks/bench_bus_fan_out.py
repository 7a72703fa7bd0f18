"""One writer and sixteen readers, one of them stopped and one slow.

Messages of 4 KB. The slow reader pauses 10 ms after each message and keeps the newest only;
the stopped one gets SIGSTOP and neither reads nor lets the link go. The writer has real-time
priority where permitted, the readers have not: sixteen processes that are woken a thousand
times per second are more than two cores can do, and what a healthy reader misses then is
counted, on the wire or in its queue of 64. At 250 Hz they can. The writer is asked for its status
ten times per second meanwhile: whoever lets one link go must still answer on the others.

Before, raw Zenoh plays the same for as long, with publisher and subscribers that have the settings
of our ports; the ratio of the gaps is to it. A gap that raw Zenoh's readers see too is the
machine's.
"""

import os
import signal
import time
from collections.abc import Iterator
from contextlib import AbstractContextManager, ExitStack, contextmanager
from typing import Any, NamedTuple

from benchmarks.children import REPORT, Child, child, hub_process
from benchmarks.rows import Row, percentiles, row
from bus import Node, RpcTimeout

PATIENCE = 30.0  # s
UNTOUCHED = 100.0  # ms: what others may notice of a reader that is stopped
READERS, SIZE, DEPTH, SLOW = 16, 4096, 64, 0.01
TABLE = "1 writer, 16 readers"
SOURCE = "/writer/data:o"
OURS, RAW = "", "raw_"  # kinds of writer and reader


def run(quick: bool = False) -> list[Row]:
    """Return the writer's times and the healthy readers' gaps, before and during the stop."""
    rates, seconds = ((1000,), 3.5) if quick else ((1000, 250), 15.0)
    return [figure for rate in rates for figure in _fan_out(rate, seconds)]


class Cast(NamedTuple):
    """The processes of one run; the slow reader is left to itself."""

    writer: Child
    healthy: list[Child]
    stopped: Child

    def phases(self, rate: int) -> Iterator[str]:
        """Name the phases, and set the scene of each before it is named."""
        yield f"{rate} Hz, all running"
        os.kill(self.stopped.pid, signal.SIGSTOP)
        yield f"{rate} Hz, one stopped, one slow"

    def worst_gap(self, start: float) -> float:
        """Return the healthy readers' worst gap since some time [ms]."""
        reports = [report for reader in self.healthy for report in _reports(reader, start)]
        return max(report["gap_ms"] for report in reports)


def _fan_out(rate: int, seconds: float) -> list[Row]:
    rows = []
    with hub_process() as (endpoint, _):
        gaps = _raw_gaps(endpoint, rate, seconds)
        with _cast(OURS, endpoint, rate) as cast, Node("fan_out", endpoint, signals=False) as node:
            time.sleep(1.0)
            for what in cast.phases(rate):
                rows += _phase(node, cast, what, seconds, gaps[what])
    return rows


@contextmanager
def _cast(kind: str, endpoint: str, rate: int) -> Iterator[Cast]:
    def reader(name: str, depth: int = DEPTH, pause: float = 0.0) -> AbstractContextManager[Child]:
        arguments = (name, endpoint, SOURCE, str(depth), str(pause))
        return child(f"benchmarks.{kind}reader", *arguments)

    with ExitStack() as stack:
        enter, arguments = stack.enter_context, ("writer", endpoint, str(rate), str(SIZE), "1")
        writer = enter(child(f"benchmarks.{kind}writer", *arguments, priority="realtime"))
        healthy = [enter(reader(f"reader{number}")) for number in range(READERS - 2)]
        slow, stopped = enter(reader("slow", 1, SLOW)), enter(reader("stopped"))
        for process in (writer, *healthy, slow, stopped):
            process.told()
        yield Cast(writer, healthy, stopped)


def _raw_gaps(endpoint: str, rate: int, seconds: float) -> dict[str, float]:
    """Return the healthy readers' worst gap of raw Zenoh in each phase [ms]."""
    gaps = {}
    with _cast(RAW, endpoint, rate) as cast:
        time.sleep(1.0)
        for what in cast.phases(rate):
            start = time.monotonic()
            time.sleep(seconds + 2 * REPORT)
            gaps[what] = cast.worst_gap(start)
    return gaps


def _phase(node: Node, cast: Cast, what: str, seconds: float, raw_gap: float) -> list[Row]:
    start = time.monotonic()
    answer = _ask(node, start + seconds)
    time.sleep(2 * REPORT)
    times = [us for report in _reports(cast.writer, start) for us in report["us"]]
    told = percentiles(times)
    rows = [
        row(
            *(f"{TABLE}, {what}: write, {name}", value, "us", None),
            limit=1000.0 if name == "p99.9" else None,
            cell=(TABLE, f"write [us]: {' / '.join(told)}", what),
        )
        for name, value in told.items()
    ]
    read = [_reports(reader, start) for reader in cast.healthy]
    received, lost, dropped = (
        sum(reports[-1][key] - reports[0][key] for reports in read)
        for key in ("received", "lost", "dropped")
    )
    share = 100.0 / max(received + lost + dropped, 1)
    return [
        *rows,
        _row(what, "question to the writer, worst", answer, "ms", UNTOUCHED),
        _row(what, "healthy readers' worst gap", cast.worst_gap(start), "ms", UNTOUCHED, raw_gap),
        _row(what, "the same with raw zenoh", raw_gap, "ms"),
        _row(what, "healthy readers, lost on the wire", share * lost, "%"),
        _row(what, "healthy readers, dropped from their queues", share * dropped, "%"),
    ]


def _ask(node: Node, end: float) -> float:
    """Ask the writer for its status until some time; return the longest time to an answer [ms]."""
    worst = 0.0
    while (start := time.monotonic()) < end:
        try:
            node.call("/writer/rpc:i", "status", timeout=PATIENCE)
        except RpcTimeout:
            pass
        worst = max(worst, time.monotonic() - start)
        time.sleep(0.1)
    return 1e3 * worst


def _row(
    what: str,
    figure: str,
    value: float,
    unit: str,
    limit: float | None = None,
    peer: float | None = None,
) -> Row:
    cell = (TABLE, f"{figure} [{unit}]", what)
    return row(f"{TABLE}, {what}: {figure}", value, unit, peer=peer, limit=limit, cell=cell)


def _reports(process: Child, start: float) -> list[dict[str, Any]]:
    """Return what a process has told of itself since some time; never nothing."""
    reports = [report for report in process.all_told() if report["time"] >= start]
    return reports or [process.told()]
