"""A process with many ports: ``python -m benchmarks.farm NAME PORTS ENDPOINT``."""

import sys
import time

from benchmarks.children import PATIENCE, own_memory, tell
from benchmarks.messages import Opaque
from bus import Node


def main() -> None:
    """Open half the ports as outputs, half as inputs; tell what that has cost; wait."""
    name, count, endpoint = sys.argv[1], int(sys.argv[2]), sys.argv[3]
    with Node(name, connect=endpoint) as node:
        memory, start = own_memory(), time.monotonic()
        for number in range(count // 2):
            node.output(f"/{name}/{number}:o", Opaque)
            node.input(f"/{name}/{number}:i", Opaque)
        opened = time.monotonic()
        node.ready(PATIENCE)
        tell(
            {
                "bytes": own_memory() - memory,
                "open_s": opened - start,
                "ready_s": time.monotonic() - opened,
            }
        )
        while node.running:
            node.wait(1.0)


if __name__ == "__main__":
    main()
