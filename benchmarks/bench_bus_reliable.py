"""How long a reliable output stalls when one of its two readers is stopped.

Messages of 4 KB at 500 Hz, since rare commands, for which such outputs are, would fill nothing.
The stopped reader (SIGSTOP) takes none; once sockets and queues are full, a write waits 20 ms for
it, and then its link is given up. The other reader is to miss nothing.
"""

import os
import signal
import time

import numpy as np

from benchmarks.children import Child, child, hub_process
from benchmarks.messages import Opaque
from benchmarks.pace import Pace, wait_until
from benchmarks.rows import Row, row
from bus import Node, Output

RATE, SECONDS = 500, 10  # Hz, s; 20 MB, more than sockets and queues hold
MESSAGE = Opaque(block=np.ones((64, 8)))  # 4 KB
STALL, WAIT = 50.0, 20.0  # ms: with what a busy machine adds; what a write waits


def run(quick: bool = False) -> list[Row]:
    """Return the times of writes [ms], and what the other reader has missed."""
    with hub_process() as (endpoint, _), Node("writer", connect=endpoint, signals=False) as node:
        output = node.output("/writer/data:o", Opaque, reliable=True)
        node.ready()
        arguments = (endpoint, "/writer/data:o", "64", "0")
        with (
            child("benchmarks.reader", "stopped", *arguments) as stopped,
            child("benchmarks.reader", "healthy", *arguments) as healthy,
        ):
            for reader in (stopped, healthy):
                reader.told()
            wait_until(lambda: output.matched)
            _write(output, RATE)
            os.kill(stopped.pid, signal.SIGSTOP)
            times = _write(output, RATE * (3 if quick else SECONDS))
            lost = _lost(healthy)
    return [
        row("reliable write, a reader stopped: p99.9", np.percentile(times, 99.9), "ms"),
        row("reliable write, a reader stopped: worst", max(times), "ms", None, STALL, WAIT),
        row("missed by the reader that goes on", lost, "messages", None, 0.0),
    ]


def _write(output: Output, count: int) -> list[float]:
    """Write messages; return how long each write took [ms]."""
    times = []
    for _ in Pace(RATE, count):
        start = time.monotonic()
        output.write(MESSAGE)
        times.append(1e3 * (time.monotonic() - start))
    return times


def _lost(reader: Child) -> int:
    """Return the messages that a reader has missed, on the wire or in its queue."""
    time.sleep(1.0)  # until it has told again
    last = reader.all_told()[-1]
    return last["lost"] + last["dropped"]
