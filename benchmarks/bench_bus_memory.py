"""Memory of hub, writer and reader while messages of 512 B go by, ten thousand per second.

Growth is the slope of the memory that each process shares with nobody, from a quarter of the
run on, by the number of messages: allocators keep some of what Python frees, so that a short
run shows up to a byte per message where a long one shows none.
"""

from typing import Any

import numpy as np

from benchmarks.children import Child, child, hub_process, own_memory
from benchmarks.rows import Row, row

MESSAGES, QUICK = 200_000, 50_000
RATE, BURST, SIZE = 1000, 10, 512
LOOKS = 100  # at the memory, at most
LEAK = 8.0  # bytes per message, less than any object of Python's


def run(quick: bool = False) -> list[Row]:
    """Return the memory of the three at the end, and how it grew."""
    return growth(QUICK if quick else MESSAGES, LEAK)


def growth(messages: int, limit: float) -> list[Row]:
    """Return the same for a number of messages, and a limit to the growth [bytes per message]."""
    numbers = [str(number) for number in (RATE, SIZE, BURST)]
    source = "/writer/data:o"
    with (
        hub_process() as (endpoint, hub),
        child("benchmarks.writer", "writer", endpoint, *numbers) as writer,
        child("benchmarks.reader", "reader", endpoint, source, "64", "0") as reader,
    ):
        writer.told()
        reader.told()
        pids = {"hub": hub, "writer": writer.pid, "reader": reader.pid}
        return _rows(_watch(writer, pids, messages), limit) + _missed(reader)


def _watch(writer: Child, pids: dict[str, int], messages: int) -> list[dict[str, Any]]:
    """Look at the memory at each report of the writer, but not more often than we want to."""
    looks: list[dict[str, Any]] = []
    written, step = 0, messages // LOOKS
    while written < messages:
        written = writer.told()["written"]
        if not looks or written >= looks[-1]["written"] + step:
            looks.append({"written": written} | {n: own_memory(pid) for n, pid in pids.items()})
    return looks


def _missed(reader: Child) -> list[Row]:
    last = reader.all_told()[-1]
    return [row("messages missed by the reader", last["lost"] + last["dropped"], "messages")]


def _rows(looks: list[dict[str, Any]], limit: float) -> list[Row]:
    late = looks[len(looks) // 4 :]
    written = np.array([look["written"] for look in late])
    rows = [row("messages written", float(written[-1]), "messages")]
    for name in ("hub", "writer", "reader"):
        memory = np.array([look[name] for look in late], float)
        slope = float(np.polyfit(written, memory, 1)[0])
        rows.append(row(f"memory of the {name} at the end", memory[-1] / 1e6, "MB"))
        rows.append(row(f"growth of the {name}", slope, "bytes per message", limit=limit))
    return rows
