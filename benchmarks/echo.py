"""The far end of a ping-pong: ``python -m benchmarks.echo TRANSPORT ENDPOINT``."""

import sys
import time

from benchmarks.children import tell
from benchmarks.transports import ENDS
from bus.service import SWITCH_INTERVAL


def main() -> None:
    """Answer every payload with one of the same size that holds the time of its arrival."""
    transport, endpoint = sys.argv[1:]
    end = ENDS[transport](endpoint, "pong", "ping")
    sys.setswitchinterval(SWITCH_INTERVAL)
    tell("ready")
    while True:
        size, _ = end.receive()
        end.send(size, float(time.monotonic_ns()))


if __name__ == "__main__":
    main()
