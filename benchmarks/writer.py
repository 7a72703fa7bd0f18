"""Writes at a rate: ``python -m benchmarks.writer NAME ENDPOINT RATE SIZE BURST``."""

import sys
import time
from typing import Any

import numpy as np

from benchmarks.children import Reporter, tell
from benchmarks.messages import Opaque
from benchmarks.pace import Pace
from bus import Node


class Writer:
    """An output, and how long its writes take."""

    def __init__(self, node: Node, name: str, size: int):
        self._output = node.output(f"/{name}/data:o", Opaque)
        self._block = np.ones((size // 64, 8))
        self._message = Opaque(block=self._block)
        self._times: list[int] = []

    def begin(self) -> None:
        """Let every message carry the time from which on we are ready [monotonic ns]."""
        self._block[0, 0] = time.monotonic_ns()

    def write(self, burst: int) -> None:
        """Write some messages, timing the first."""
        start = time.monotonic_ns()
        self._output.write(self._message)
        self._times.append(time.monotonic_ns() - start)
        for _ in range(burst - 1):
            self._output.write(self._message)

    def report(self) -> dict[str, Any]:
        """Return the write times since the last report [us], and the number of all writes."""
        times, self._times = self._times, []
        return {"us": [1e-3 * ns for ns in times], "written": self._output.statistics.written}


def main() -> None:
    """Write until asked to end."""
    name, endpoint, (rate, size, burst) = sys.argv[1], sys.argv[2], map(int, sys.argv[3:])
    with Node(name, connect=endpoint) as node:
        writer = Writer(node, name, size)
        node.ready()
        writer.begin()
        tell("ready")
        reporter = Reporter(writer.report)
        for _ in Pace(rate):
            writer.write(burst)
            reporter.tell()
            node.wait(0.0)
            if not node.running:
                break


if __name__ == "__main__":
    main()
