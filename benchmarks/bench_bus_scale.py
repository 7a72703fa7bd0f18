"""A thousand ports in twenty processes.

A node that has just been opened lists them all, asks each for its description, and connects
a hundred pairs of an output and an input in other processes; the time to the first connection
begins before the node is opened. Memory is what a process shares with nobody.
"""

import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager

import numpy as np

from benchmarks.children import child, hub_process, own_memory
from benchmarks.pace import wait_until
from benchmarks.rows import Row, row
from bus import Node
from bus.introspection import hear_all, port_infos
from bus.wiring import connect

PROCESSES, PORTS = 20, 50  # each
AT_ONCE = 2  # processes that start at the same time, one per core
PATIENCE = 60.0  # s


def run(quick: bool = False) -> list[Row]:
    """Return how long it takes to know all ports, and what a port costs."""
    with hub_process() as (endpoint, hub):
        empty_hub = own_memory(hub)
        with farms(endpoint) as (ready_after, costs):
            full_hub = own_memory(hub)
            rows = _newcomer(endpoint, 20 if quick else 100)
    ports = PROCESSES * PORTS
    mean = {name: float(np.mean([cost[name] for cost in costs])) / PORTS for name in costs[0]}
    return [
        *rows,
        row("start of 20 processes with 50 ports each, until all are ready", ready_after, "s"),
        row("a port: memory in its process", mean["bytes"] / 1024, "KiB"),
        row("a port: memory in the hub", (full_hub - empty_hub) / 1024 / ports, "KiB"),
        row("a port: time to open it, two processes starting at once", 1e3 * mean["open_s"], "ms"),
        row("a port: its share in getting ready, likewise", 1e3 * mean["ready_s"], "ms"),
    ]


@contextmanager
def farms(endpoint: str) -> Iterator[tuple[float, list[dict[str, float]]]]:
    """Start the processes; return the time until all are ready [s] and what each one tells."""
    with ExitStack() as stack:
        start = time.monotonic()
        costs = []
        for first in range(0, PROCESSES, AT_ONCE):
            numbers = range(first, first + AT_ONCE)
            arguments = [("benchmarks.farm", f"farm{n}", str(PORTS), endpoint) for n in numbers]
            processes = [stack.enter_context(child(*each)) for each in arguments]
            costs += [process.told() for process in processes]
        yield time.monotonic() - start, costs


def _newcomer(endpoint: str, connects: int) -> list[Row]:
    memory, start = own_memory(), time.monotonic()
    with Node("newcomer", connect=endpoint, signals=False) as node:
        listed = _listed(node)
        at_list = time.monotonic() - start
        hear_all(node)
        settled = time.monotonic() - start
        described = [info for info in port_infos(node, listed, PATIENCE) if "fields" in info]
        at_description = time.monotonic() - start
        took = [_connect(node, number) for number in range(connects)]
        memory = own_memory() - memory
    rows = [
        row("1000 ports, from opening a node: all listed", at_list, "s", limit=2.0),
        row("1000 ports, from opening a node: known to be all", settled, "s"),
        row("1000 ports, from opening a node: all described", at_description, "s", limit=2.0),
        row(
            *("1000 ports, from opening a node: first connection made", at_description + took[0]),
            *("s", None, 2.0),
        ),
        row("1000 ports: described", len(described), "ports"),
        row("a connect among 1000 ports, median", 1e3 * float(np.median(took)), "ms"),
    ]
    rate = len(took) / sum(took)
    target = {"target": ">= 100 per second", "met": rate >= 100.0}
    return [
        *rows,
        row("connects, one after the other", rate, "per second") | target,
        row("a port: memory in a node that lists it", memory / 1024 / (PROCESSES * PORTS), "KiB"),
    ]


def _listed(node: Node) -> list[str]:
    """Return the names of all ports of the farms, when all are there."""

    def names() -> list[str]:
        return [name for name in node.directory.names() if name.startswith("/farm")]

    wait_until(lambda: len(names()) >= PROCESSES * (PORTS + 1), PATIENCE)  # and one RPC port each
    return [name for name in names() if "rpc" not in name]


def _connect(node: Node, number: int) -> float:
    """Connect a pair; return how long it took [s]."""
    writer, reader = number % PROCESSES, (number + 1) % PROCESSES
    port = number // PROCESSES
    start = time.monotonic()
    connect(node, f"/farm{writer}/{port}:o", f"/farm{reader}/{port}:i")
    return time.monotonic() - start
