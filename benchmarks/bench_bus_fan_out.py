"""One writer and sixteen readers, one of them stopped and one slow.

Messages of 4 KB. The slow reader pauses 10 ms after each message and keeps the newest only;
the stopped one gets SIGSTOP and neither reads nor lets the link go. The writer has real-time
priority where permitted, the readers have not: sixteen processes that are woken a thousand
times per second are more than two cores can do, and what a healthy reader misses then is
counted, on the wire or in its queue of 64. At 250 Hz they can. The writer is asked for its status
ten times per second meanwhile: whoever lets one link go must still answer on the others.
"""

import os
import signal
import time
from contextlib import AbstractContextManager, ExitStack
from typing import Any

from benchmarks.children import REPORT, Child, child, hub_process
from benchmarks.rows import Row, percentiles, row
from bus import Node, RpcTimeout

PATIENCE = 30.0  # s
UNTOUCHED = 100.0  # ms: what others may notice of a reader that is stopped
READERS, SIZE, DEPTH, SLOW = 16, 4096, 64, 0.01
TABLE = "1 writer, 16 readers"
SOURCE = "/writer/data:o"


def run(quick: bool = False) -> list[Row]:
    """Return the writer's times and the healthy readers' gaps, before and during the stop."""
    rates, seconds = ((1000,), 3.5) if quick else ((1000, 250), 15.0)
    return [figure for rate in rates for figure in _fan_out(rate, seconds)]


def _fan_out(rate: int, seconds: float) -> list[Row]:
    arguments = (str(rate), str(SIZE), "1")
    with hub_process() as (endpoint, _), ExitStack() as stack:
        enter = stack.enter_context
        writer = enter(
            child("benchmarks.writer", "writer", endpoint, *arguments, priority="realtime")
        )
        healthy = [enter(_reader(f"reader{number}", endpoint)) for number in range(READERS - 2)]
        slow = enter(_reader("slow", endpoint, 1, SLOW))
        stopped = enter(_reader("stopped", endpoint))
        for process in (writer, *healthy, slow, stopped):
            process.told()
        with Node("fan_out", connect=endpoint, signals=False) as node:
            time.sleep(1.0)
            rows = _phase(node, writer, healthy, f"{rate} Hz, all running", seconds)
            os.kill(stopped.pid, signal.SIGSTOP)
            what = f"{rate} Hz, one stopped, one slow"
            return rows + _phase(node, writer, healthy, what, seconds)


def _reader(
    name: str, endpoint: str, depth: int = DEPTH, pause: float = 0.0
) -> AbstractContextManager[Child]:
    return child("benchmarks.reader", name, endpoint, SOURCE, str(depth), str(pause))


def _phase(node: Node, writer: Child, healthy: list[Child], what: str, seconds: float) -> list[Row]:
    start = time.monotonic()
    answer = _ask(node, start + seconds)
    time.sleep(2 * REPORT)
    times = [us for report in _reports(writer, start) for us in report["us"]]
    told = percentiles(times)
    rows = [
        row(
            *(f"{TABLE}, {what}: write, {name}", value, "us", None),
            limit=1000.0 if name == "p99.9" else None,
            cell=(TABLE, f"write [us]: {' / '.join(told)}", what),
        )
        for name, value in told.items()
    ]
    read = [_reports(reader, start) for reader in healthy]
    gap = max(report["gap_ms"] for reports in read for report in reports)
    received, lost, dropped = (
        sum(reports[-1][key] - reports[0][key] for reports in read)
        for key in ("received", "lost", "dropped")
    )
    share = 100.0 / max(received + lost + dropped, 1)
    return [
        *rows,
        _row(what, "question to the writer, worst", answer, "ms", UNTOUCHED),
        _row(what, "healthy readers' worst gap", gap, "ms", UNTOUCHED),
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


def _row(what: str, figure: str, value: float, unit: str, limit: float | None = None) -> Row:
    cell = (TABLE, f"{figure} [{unit}]", what)
    return row(f"{TABLE}, {what}: {figure}", *(value, unit), limit=limit, cell=cell)


def _reports(process: Child, start: float) -> list[dict[str, Any]]:
    """Return what a process has told of itself since some time; never nothing."""
    reports = [report for report in process.all_told() if report["time"] >= start]
    return reports or [process.told()]
