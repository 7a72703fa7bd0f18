"""How soon names vanish, and how soon one of several claimants has a name.

A process that has names is killed (SIGKILL), another one stopped (SIGSTOP), which is as if it
were cut off: from there until a node elsewhere sees its names no more. The lease is 2 s, and
Zenoh's timer is some milliseconds late. Then four linked nodes open the same port at once, with a
hub, and some seconds after it was killed: from there until one of them has the name, and how many
have it when all have been told.
"""

import os
import signal
import threading
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import numpy as np

from benchmarks.children import child
from benchmarks.messages import Opaque
from benchmarks.rows import Row, row
from bus import NameTaken, Node
from bus.session import LEASE
from bus.testing import start_hub

CLAIMANTS = 4
ALONE = 3.0  # s that a hub is gone
LATE = 0.1  # s; of Zenoh's timer


def run(quick: bool = False) -> list[Row]:
    """Return the times until names vanish [ms, s], and until they are agreed on [ms]."""
    times = 2 if quick else 10
    endpoint, hub = start_hub()
    try:
        killed = [_vanishing(endpoint, signal.SIGKILL) for _ in range(times)]
        stopped = [_vanishing(endpoint, signal.SIGSTOP) for _ in range(times // 2)]
        with _claimants(endpoint) as nodes:
            with_hub = [_contest(nodes, f"/with/{k}:o") for k in range(times)]
            hub.kill()
            time.sleep(ALONE)
            without = [_contest(nodes, f"/without/{k}:o") for k in range(times)]
    finally:
        hub.clean_up()
    return [
        row("killed process: until its names vanish, median", 1e3 * np.median(killed), "ms"),
        row("killed process: until its names vanish, worst", 1e3 * max(killed), "ms", None, 100.0),
        row(
            "stopped process: until its names vanish, worst", max(stopped), "s", None, LEASE + LATE
        ),
        *_agreement("with a hub", with_hub),
        *_agreement("without one", without),
    ]


def _agreement(where: str, contests: list[tuple[float, int]]) -> list[Row]:
    times, winners = zip(*contests, strict=True)
    amiss, who = sum(number != 1 for number in winners), f"claimants {where}"
    return [
        row(f"{who}: until one has the name, worst", 1e3 * max(times), "ms", None, 500.0),
        row(f"{who}: times that not exactly one had it", amiss, "times", None, 0.0),
    ]


def _vanishing(endpoint: str, number: signal.Signals) -> float:
    """Signal a process that has names; return how long they are still seen [s]."""
    with Node("bench", connect=endpoint, signals=False) as node:
        node.ready()
        with child("benchmarks.writer", "writer", endpoint, "100", "64", "1") as writer:
            writer.told()
            _until(lambda: node.directory.owner("/writer/data:o") is not None)
            start = time.monotonic()
            os.kill(writer.pid, number)
            _until(lambda: node.directory.owner("/writer/data:o") is None)
            return time.monotonic() - start


@contextmanager
def _claimants(endpoint: str) -> Iterator[list[Node]]:
    with ExitStack() as stack:
        names = [f"claimant{k}" for k in range(CLAIMANTS)]
        nodes = [stack.enter_context(Node(n, connect=endpoint, signals=False)) for n in names]
        for node in nodes:
            node.ready()
        yield nodes


def _contest(nodes: list[Node], name: str) -> tuple[float, int]:
    """Let all open a port at once; return when one has it [s], and how many have it at the end."""
    barrier, won = threading.Barrier(len(nodes)), []

    def claim(node: Node) -> None:
        barrier.wait()
        start = time.monotonic()
        try:
            port = node.output(name, Opaque)
        except NameTaken:
            return
        won.append((time.monotonic() - start, port))

    threads = [threading.Thread(target=claim, args=(node,)) for node in nodes]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    return min((took for took, _ in won), default=np.inf), sum(port.standing for _, port in won)


def _until(true) -> None:
    deadline = time.monotonic() + 30.0
    while not true():
        if time.monotonic() > deadline:
            raise TimeoutError("not within 30 s")
        time.sleep(0.001)
