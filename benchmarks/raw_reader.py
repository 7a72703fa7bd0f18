"""The peer of `benchmarks.reader`, with the same arguments: Zenoh's own Python interface."""

import sys
import time
from typing import Any

import zenoh
from zenoh.handlers import RingChannel

from benchmarks.children import Reporter, tell
from bus.names import key_of
from bus.session import LOOPBACK, open_session


class RawReader:
    """A subscriber that keeps the newest, and the gaps between its messages."""

    def __init__(self, session: zenoh.Session, source: str, depth: int):
        self._subscriber = session.declare_subscriber(key_of(source), RingChannel(depth))
        self._last = self._gap = 0

    def read(self) -> None:
        """Wait for a message."""
        self._subscriber.recv().payload.to_bytes()
        now = time.monotonic_ns()
        self._gap = max(self._gap, now - (self._last or now))
        self._last = now

    def report(self) -> dict[str, Any]:
        """Return the worst gap since the last report [ms]."""
        gap, self._gap = self._gap, 0
        return {"gap_ms": 1e-6 * gap}


def main() -> None:
    """Read until killed; a slow reader pauses after each message."""
    _, endpoint, source, depth, pause = sys.argv[1:]
    with open_session("peer", [endpoint], [LOOPBACK]) as session:
        reader = RawReader(session, source, int(depth))
        tell("ready")
        reporter = Reporter(reader.report)
        while True:
            reader.read()
            reporter.tell()
            if float(pause):
                time.sleep(float(pause))


if __name__ == "__main__":
    main()
