"""Opening, closing and opening again; who is connected; who does not read."""

import socket
import threading
import time
from contextlib import contextmanager

import pytest

from bus import BusError, Node
from bus.testing import collect, eventually
from bus.wiring import connections
from tests.bus.messages import Number

CLOSED_SOON = 20.0  # s; usually 10 ms


@contextmanager
def closing():
    """Assert that what is done inside does not hang."""
    began = time.monotonic()
    yield
    assert time.monotonic() - began < CLOSED_SOON


def open_writer(hub, **more):
    node = Node("w", connect=hub, signals=False)
    out = node.output("/w/x:o", Number, **more)
    node.ready()
    return node, out


def open_reader(hub, name="r", **more):
    node = Node(name, connect=hub, signals=False)
    inp = node.input(f"/{name}/x:i", Number, source="/w/x:o", **more)
    node.ready()
    return node, inp


def test_a_name_is_opened_and_closed_twenty_times_in_a_fast_loop(hub):
    reader, inp = open_reader(hub, depth=64)
    with reader:
        for k in range(20):
            writer, out = open_writer(hub)
            with writer:
                eventually(lambda out=out: out.matched)
                out.write(Number(value=float(k)))
                assert [r.data.value for r in collect(reader, inp, 1)] == [float(k)]
        assert inp.statistics.foreign == inp.statistics.lost == 0
        eventually(lambda: reader.directory.owner("/w/x:o") is None)


def test_a_port_opened_again_shows_no_old_message(hub):
    writer, out = open_writer(hub)
    with writer:
        reader, inp = open_reader(hub, depth=64)
        with reader:
            eventually(lambda: out.matched)
            out.write(Number(value=1.0))
            collect(reader, inp, 1)
            out.write(Number(value=2.0))  # is never read
        eventually(lambda: not out.matched)
        out.write(Number(value=3.0))  # nobody is there
        reader, inp = open_reader(hub, depth=64)
        with reader:
            eventually(lambda: out.matched)
            assert inp.read() is None and inp.latest is None and not inp.fresh
            out.write(Number(value=4.0))
            assert [r.data.value for r in collect(reader, inp, 1)] == [4.0]
            assert inp.statistics.lost == 0


def test_a_writer_without_readers_writes_at_once_and_to_nobody(hub):
    writer, out = open_writer(hub)
    with writer:
        began = time.monotonic()
        for k in range(1000):
            out.write(Number(value=float(k)))
        assert time.monotonic() - began < 5.0  # 10 ms on a quiet machine
        assert not out.matched and out.statistics.written == 1000


@pytest.mark.parametrize("first", ["writer", "reader"])
@pytest.mark.parametrize("stream", ["state", "command"])
def test_whichever_side_closes_first_neither_hangs_though_nobody_reads(hub, first, stream):
    writer, out = open_writer(hub, reliable=stream == "command")
    reader, _ = open_reader(hub, depth=8)
    ends = {"writer": writer, "reader": reader}
    try:
        eventually(lambda: out.matched)
        for k in range(5000):  # more than the input keeps
            out.write(Number(value=float(k)))
        with closing():
            ends.pop(first).close()
        if first == "reader":
            eventually(lambda: not out.matched)
            out.write(Number(value=0.0))
        with closing():
            ends.popitem()[1].close()
    finally:
        for node in ends.values():
            node.close()


def test_connections_are_counted_exactly(hub, node):
    node.ready()
    writer, out = open_writer(hub)
    readers = [open_reader(hub, name=f"r{k}") for k in range(3)]

    def sinks():
        return [sink for source, sink, *_ in connections(node) if source == "/w/x:o"]

    try:
        for k, (reader, _) in enumerate(readers):
            eventually(lambda k=k: sinks() == [f"/r{j}/x:i" for j in range(k, 3)])
            assert out.matched
            reader.close()
        eventually(lambda: sinks() == [] and not out.matched)
    finally:
        for opened in (writer, *(reader for reader, _ in readers)):
            opened.close()


def test_a_message_that_is_kept_does_not_change_while_newer_ones_come(hub):
    writer, out = open_writer(hub)
    reader, inp = open_reader(hub)
    with writer, reader:
        eventually(lambda: out.matched)
        out.write(Number(value=1.0))
        (kept,) = collect(reader, inp, 1)
        for value in (2.0, 3.0, 4.0):
            out.write(Number(value=value))
            collect(reader, inp, 1)
        assert kept.data.value == 1.0 and kept.envelope.seq == 1


def test_a_wait_ends_when_the_node_is_stopped_in_another_thread(node):
    node.ready()
    threading.Timer(0.05, node.stop).start()
    with closing():
        while node.running:
            node.wait(600.0)


def test_who_accepts_and_says_nothing_is_no_hub():
    with socket.create_server(("127.0.0.1", 0)) as silent:
        endpoint = f"tcp/127.0.0.1:{silent.getsockname()[1]}"
        with closing(), Node("alone", connect=endpoint, signals=False) as node:
            with pytest.raises(BusError, match=f"no hub at {endpoint}"):
                node.ready(timeout=0.3)


def test_a_port_is_closed_while_it_is_written_to(hub):
    """The name is given back; the thread that writes is told."""
    writer, out = open_writer(hub)
    told = threading.Event()

    def write():
        try:
            while True:
                out.write(Number(value=1.0))
        except BusError:
            told.set()

    thread = threading.Thread(target=write)
    thread.start()
    with closing():
        writer.close()
    thread.join(CLOSED_SOON)
    assert told.is_set()


def test_nodes_that_are_closed_at_once_are_gone(hub, node):
    """Zenoh keeps for good what a session dials while it closes."""
    node.ready()
    before = {str(peer) for peer in node.session.info.peers_zid()}
    for k in range(10):
        Node(f"brief{k}", connect=hub, signals=False).close()
    eventually(lambda: {str(peer) for peer in node.session.info.peers_zid()} <= before)
