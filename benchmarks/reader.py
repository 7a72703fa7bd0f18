"""Reads what a writer writes: ``python -m benchmarks.reader NAME ENDPOINT SOURCE DEPTH PAUSE``."""

import sys
import time
from typing import Any

from benchmarks.children import Reporter, tell
from benchmarks.messages import Opaque
from bus import Node

MOST = 16  # messages at once


class Reader:
    """An input, and the gaps between its messages."""

    def __init__(self, node: Node, name: str, source: str, depth: int):
        self._input = node.input(f"/{name}/data:i", Opaque, source or (), depth)
        self._last = self._gap = self._first = 0
        node.verb("first", self.first)

    def read(self, pause: float) -> bool:
        """Read what is there; a slow reader pauses after each message [s].

        Returns whether there may be more.
        """
        for _ in range(MOST):
            if self._input.read() is None:
                return False
            now = time.monotonic_ns()
            self._first = self._first or now
            if self._last:
                self._gap = max(self._gap, now - self._last)
            self._last = now
            if pause:
                time.sleep(pause)
        return True

    def report(self) -> dict[str, Any]:
        """Return the worst gap since the last report [ms], and all counters."""
        gap, self._gap = self._gap, 0
        return self._input.statistics.as_map() | {"gap_ms": 1e-6 * gap}

    def first(self) -> int:
        """Return when the first message came since this was asked last [monotonic ns], or 0."""
        first, self._first = self._first, 0
        return first


def main() -> None:
    """Read until asked to end."""
    name, endpoint, source, depth, pause = sys.argv[1:]
    with Node(name, connect=endpoint) as node:
        reader = Reader(node, name, source, int(depth))
        node.ready()
        tell({"ready": time.monotonic_ns()})
        reporter, more = Reporter(reader.report), False
        while node.running:
            node.wait(0.0 if more else 0.1)
            more = reader.read(float(pause))
            reporter.tell()


if __name__ == "__main__":
    main()
