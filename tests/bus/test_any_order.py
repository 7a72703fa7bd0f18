"""Hub, writer and reader as processes: started in any order, killed, stopped, restarted."""

import signal
import time
from collections.abc import Callable, Iterator

import pytest

from bus import Node, RpcError
from bus.testing import Process, eventually, free_port

MODULES = {"hub": "bus.hub", "writer": "tests.bus.source", "reader": "tests.bus.sink"}
MORE = 2.0  # s beyond the lease, until everybody else has given the stopped one up too
MUCH_TOO_OLD = 1.0  # s; the limit is 0.1 s, but this machine may be busy


class Line:
    """The three processes, and a node of the test that asks the reader."""

    def __init__(self) -> None:
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        self.processes: dict[str, Process] = {}
        self._all: list[Process] = []

    def start(self, party: str) -> Process:
        """Start one; do not wait for it."""
        arguments = ("--connect", self.endpoint)
        if party == "hub":
            arguments = ("--listen", self.endpoint, "--settle", "0.1", "--no-announce")
        process = self.processes[party] = Process(MODULES[party], *arguments)
        self._all.append(process)
        return process

    def flows(self, node: Node) -> None:
        """Wait until fresh data come to the reader; no old ones were taken for fresh."""

        def fresh() -> bool:
            report = self.ask(node)
            assert not report or report["oldest_fresh"] < MUCH_TOO_OLD
            return bool(report and report["received"] > 3 and report["is_fresh"])

        eventually(lambda: self.ask(node, clear=True), 60.0, "the reader's report")
        eventually(fresh, 60.0, "fresh data")

    def ask(self, node: Node, clear: bool = False):
        """Return what the reader has seen; None when it does not answer."""
        try:
            return node.call("/sink/rpc:i", "report", {"clear": clear}, timeout=1.0)
        except RpcError:
            return None

    def ends(self) -> None:
        """End all, as a signal does."""
        for party, process in self.processes.items():
            assert process.stop() == 0, f"{party}: {process.output}"

    def end(self) -> None:
        for process in self._all:
            process.clean_up()


@pytest.fixture
def line() -> Iterator[Line]:
    line = Line()
    yield line
    line.end()


@pytest.fixture
def watch(line: Line) -> Iterator[Callable[[], Node]]:
    """Return a function that opens the test's node."""
    nodes: list[Node] = []

    def opened() -> Node:
        nodes.append(Node("watch", connect=line.endpoint, signals=False))
        return nodes[-1]

    yield opened
    for node in nodes:
        node.close()


@pytest.fixture
def node(line: Line, watch) -> Node:
    """The test's node on a line that runs."""
    for party in MODULES:
        line.start(party)
    node = watch()
    line.flows(node)
    return node


@pytest.mark.parametrize("order", ["hub reader writer", "writer hub reader", "reader writer hub"])
def test_started_in_any_order_all_find_each_other(line, watch, order):
    for party in order.split():
        line.start(party)
    line.flows(watch())
    line.ends()


def test_whoever_is_killed_and_restarted_is_found_again_and_the_others_go_on(line, node):
    for party in MODULES:
        line.processes[party].kill()
        if party == "hub":
            line.flows(node)  # without it
        elif party == "writer":
            eventually(lambda: (report := line.ask(node)) and not report["is_fresh"])
        line.start(party)
        line.flows(node)
    assert eventually(lambda: line.ask(node))["statistics"]["foreign"] == 0
    with Node("newcomer", connect=line.endpoint, signals=False) as newcomer:
        newcomer.ready(timeout=30.0)
        eventually(lambda: {"/source/out:o", "/sink/in:i"} <= set(newcomer.directory.names()))
    line.ends()


def test_whoever_was_stopped_goes_on_and_no_old_message_is_taken_for_a_fresh_one(line, node):
    ports = {"hub": "/hub/rpc:i", "writer": "/source/out:o", "reader": "/sink/in:i"}
    for party, name in ports.items():
        eventually(lambda name=name: node.directory.owner(name))
        line.processes[party].send(signal.SIGSTOP)
        eventually(lambda name=name: node.directory.owner(name) is None, what="the lease's end")
        until = time.monotonic() + MORE
        eventually(lambda until=until: time.monotonic() > until)
        if party == "hub":
            line.flows(node)
        line.processes[party].send(signal.SIGCONT)
        line.flows(node)
        eventually(lambda name=name: node.directory.owner(name))
    line.ends()
