"""Writes down, on some host, what arrives from a port and how an input judges it.

Usage: ``python -m tests.multihost.witness HUB LISTEN NAMESPACE KEY FILE``. A line of JSON per
message and per change of the input's state; ``at`` is the monotonic clock [s], which all hosts
of a test share.
"""

import json
import sys
import time
from typing import IO, Any

from bus import Input, Node
from robot_model import load_robot, messages, ports


def main() -> None:
    """Write until asked to end."""
    hub, listen, namespace, key, file = sys.argv[1:]
    robot = load_robot("icub")
    name = f"witness-{listen.split('/')[1].split(':')[0]}-{key}"
    with (
        Node(name, connect=hub, listen=listen, namespace=namespace, insecure=True) as node,
        open(file, "w") as lines,
    ):
        port = node.input(
            f"/{name}/{key}:i",
            getattr(messages, ports.port(key).message),
            source=ports.name(key, robot),
            depth=64,
            rate=ports.rate(key),
            model=robot.model_hash,
            dimensions=robot.dimensions,
        )
        node.ready()
        watch(node, port, lines)


def watch(node: Node, port: Input, lines: IO[str]) -> None:
    """Write what comes, and every change between fresh and stale."""
    fresh = None
    while node.running:
        node.wait(0.005)
        while (received := port.read()) is not None:
            envelope = received.envelope
            entry = {
                "at": received.arrival * 1e-9,
                "stamp": envelope.stamp,
                "age": (time.time_ns() - envelope.acquired) * 1e-9,
                "source": envelope.source.hex(),
                "valid": envelope.valid,
                "fresh": port.fresh,
                "reason": envelope.reason or port.reason,
            }
            write(lines, entry)
        if port.fresh != fresh:
            fresh = port.fresh
            write(lines, {"at": time.monotonic(), "fresh": fresh, "reason": port.reason})


def write(lines: IO[str], entry: dict[str, Any]) -> None:
    """Write one line at once."""
    lines.write(json.dumps(entry) + "\n")
    lines.flush()


if __name__ == "__main__":
    main()
