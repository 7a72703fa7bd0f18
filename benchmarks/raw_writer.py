"""The peer of `benchmarks.writer`, with the same arguments: Zenoh's own Python interface."""

import sys
import time
from typing import Any

import zenoh

from benchmarks.children import Reporter, tell
from benchmarks.pace import Pace
from bus.session import LOOPBACK, open_session


class RawWriter:
    """A publisher with the settings of our outputs, and how long its puts take."""

    def __init__(self, session: zenoh.Session, name: str, size: int):
        self._publisher = session.declare_publisher(
            f"{name}/data:o",
            congestion_control=zenoh.CongestionControl.DROP,
            priority=zenoh.Priority.REAL_TIME,
            express=True,
        )
        self._payload = bytes(size)
        self._times: list[int] = []

    def write(self, burst: int) -> None:
        """Put some payloads, timing the first."""
        start = time.monotonic_ns()
        self._publisher.put(self._payload)
        self._times.append(time.monotonic_ns() - start)
        for _ in range(burst - 1):
            self._publisher.put(self._payload)

    def report(self) -> dict[str, Any]:
        """Return the times since the last report [us]."""
        times, self._times = self._times, []
        return {"us": [1e-3 * ns for ns in times]}


def main() -> None:
    """Write until killed."""
    name, endpoint, (rate, size, burst) = sys.argv[1], sys.argv[2], map(int, sys.argv[3:])
    with open_session("peer", [endpoint], [LOOPBACK]) as session:
        writer = RawWriter(session, name, size)
        tell("ready")
        reporter = Reporter(writer.report)
        for _ in Pace(rate):
            writer.write(burst)
            reporter.tell()


if __name__ == "__main__":
    main()
