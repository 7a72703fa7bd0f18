"""How soon data flow again after a writer was killed, and what a connect takes.

The writer is killed and started again; the reader, which has only its name, is left alone.
From the writer's readiness (all its names are granted) to the first datum in the reader's
hands; and from the start of the new process, most of which is the start of Python. Likewise for a
reader that is killed, and connected for good (--persist) to a writer that goes on. A connect
lasts from the call to the answer of the input's owner, and to the first datum after it. For
scale: YARP 4.0 took 41 ms from the restart of a killed reader to its first datum, in C++.
"""

import time

import numpy as np

from benchmarks.children import child, hub_process
from benchmarks.messages import Opaque
from benchmarks.rows import Row, row
from bus import Input, Node, Received
from bus.wiring import connect, disconnect

PAIR = "/writer/data:o", "/reader/data:i"


def run(quick: bool = False) -> list[Row]:
    """Return the times of returns and of connects [ms]."""
    with hub_process() as (endpoint, _), Node("bench", connect=endpoint, signals=False) as node:
        port = node.input("/bench/data:i", Opaque, "/writer/data:o")
        node.ready()
        returns = [_return(endpoint, node, port) for _ in range(4 if quick else 20)]
        with child("benchmarks.writer", "writer", endpoint, "1000", "512", "1") as writer:
            with child("benchmarks.reader", "reader", endpoint, "", "64", "0") as reader:
                writer.told()
                reader.told()
                connects = [_connect(node) for _ in range(20 if quick else 200)]
            connect(node, *PAIR, persist=True)
            inputs = [_input_return(endpoint, node) for _ in range(4 if quick else 20)]
    ready, start = (np.array(column) for column in zip(*returns, strict=True))
    heard, begun = (np.array(column) for column in zip(*inputs, strict=True))
    made, came = (np.array(column) for column in zip(*connects, strict=True))
    return [
        row(
            *("killed output: from its readiness to the first datum, median", np.median(ready)),
            *("ms", None, 50.0),
        ),
        row("killed output: likewise, worst", max(ready), "ms"),
        row("killed output: from its start to the first datum, median", np.median(start), "ms"),
        row(
            *(
                "killed input: from its readiness to the first datum, median",
                np.median(heard),
            ),
            *("ms", None, 50.0),
        ),
        row("killed input: from its start to the first datum, median", np.median(begun), "ms"),
        row("connect: until answered, median", np.median(made), "ms"),
        row("connect: until answered, p99", np.percentile(made, 99), "ms"),
        row("connect: until the first datum of a stream at 1 kHz, median", np.median(came), "ms"),
    ]


def _return(endpoint: str, node: Node, port: Input) -> tuple[float, float]:
    """Start a writer and kill it; return readiness and start to the first datum [ms]."""
    port.newest()
    start = time.monotonic_ns()
    with child("benchmarks.writer", "writer", endpoint, "1000", "512", "1") as writer:
        received = _next(node, port)
        now, ready = time.monotonic_ns(), received.data.block[0, 0]
        writer.told()
        writer.kill()
        node.wait(0.1)
    return 1e-6 * (now - ready), 1e-6 * (now - start)


def _connect(node: Node) -> tuple[float, float]:
    """Connect and disconnect; return until the answer, and until the first datum [ms]."""
    node.call("/reader/rpc:i", "first")
    start = time.monotonic_ns()
    connect(node, *PAIR)
    made = time.monotonic_ns()
    first = _first(node)
    disconnect(node, *PAIR)
    return 1e-6 * (made - start), 1e-6 * (first - start)


def _input_return(endpoint: str, node: Node) -> tuple[float, float]:
    """Start a reader and kill it; return readiness and start to the first datum [ms]."""
    start = time.monotonic_ns()
    with child("benchmarks.reader", "reader", endpoint, "", "64", "0") as reader:
        ready, first = reader.told()["ready"], _first(node)
        reader.kill()
        node.wait(0.1)
    return 1e-6 * max(first - ready, 0), 1e-6 * (first - start)


def _first(node: Node) -> int:
    """Return when the reader got its first message since it was asked last [monotonic ns]."""
    first = 0
    while not first:
        first = node.call("/reader/rpc:i", "first")
    return first


def _next(node: Node, port: Input) -> Received:
    deadline = time.monotonic() + 30.0
    while (received := port.read()) is None:
        node.wait(0.1)
        if time.monotonic() > deadline:
            raise TimeoutError(f"nothing came on {port.name} within 30 s: {port.reason}")
    return received
