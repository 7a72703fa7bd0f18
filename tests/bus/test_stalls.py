"""A stopped reader delays nobody."""

import os
import signal
import threading
import time

import pytest

from bus import Node
from bus.testing import eventually
from tests.bus.messages import Mixed, Number, mixed


@pytest.fixture
def writer(hub):
    with Node("test", connect=hub, signals=False) as node:
        yield node


@pytest.mark.parametrize("reliable", [False, True], ids=["state", "command"])
def test_a_stopped_reader_delays_neither_the_writer_nor_another_reader(
    start, hub, writer, reliable
):
    stopped = start("tests.bus.toys", service="toy")
    start("tests.bus.toys", "--name", "healthy", "--set", "output=/healthy/out:o")
    out = writer.output("/test/out:o", Number, rate=500.0, reliable=reliable)
    big = writer.output("/test/big:o", Mixed, reliable=reliable, max_message=1 << 20)
    sink = writer.input("/test/in:i", Number, source="/healthy/out:o", depth=4096)
    other = writer.input("/test/other:i", Number, source="/toy/out:o", depth=4096)
    writer.ready()
    eventually(lambda: out.matched and writer.directory.leader("/healthy/out:o"))
    stopped.send(signal.SIGSTOP)
    load, durations, answered = mixed(n=20_000), [], 0
    end = time.monotonic() + 3.0
    # 20 MB or more, far beyond what sockets and queues hold for the stopped one
    while time.monotonic() < end or len(durations) < 100:
        began = time.monotonic()
        out.write(Number(value=1.0))
        big.write(load)
        durations.append(time.monotonic() - began)
        writer.wait(0.002)
        while (received := sink.read()) is not None:
            answered += received.envelope.valid
    # 5 s with Zenoh's defaults; a reader that holds up reliable messages is cut off at once
    assert max(durations) < 2.0, max(durations)
    assert answered > 0
    while other.read() is not None:
        pass
    stopped.send(signal.SIGCONT)

    def back():
        out.write(Number(value=1.0))
        writer.wait(0.005)
        received = other.newest()
        return received is not None and received.envelope.valid

    eventually(back, what="the stopped reader works again")


STOP = float(os.environ.get("WRENCHBUS_STOP", "3.0"))  # s; a longer run takes 30


def test_a_reader_that_was_stopped_sees_fresh_data_first(start, node):
    start("tests.bus.source", "--set", "rate=500", service="source")
    sink = start("tests.bus.sink", "--set", "depth=64", "--set", "rate=500", service="sink")
    ask = lambda clear=False: node.call("/sink/rpc:i", "report", {"clear": clear})  # noqa: E731
    eventually(lambda: ask()["is_fresh"])
    ask(clear=True)
    sink.send(signal.SIGSTOP)
    until = time.monotonic() + STOP
    eventually(lambda: time.monotonic() > until, STOP + 30.0)
    sink.send(signal.SIGCONT)
    eventually(lambda: (report := ask())["received"] > 100 and report["is_fresh"])
    report = ask()
    assert report["old"] <= 5, report  # those that it had got, and not read, before the stop
    assert report["oldest_fresh"] < 1.0, report


def test_a_slow_reader_keeps_up_with_the_newest_and_counts_what_it_skips(hub, writer):
    out = writer.output("/test/out:o", Number, rate=1000.0)
    with Node("slow", connect=hub, signals=False) as slow:
        inp = slow.input("/slow/in:i", Number, source="/test/out:o", rate=1000.0)
        slow.ready()
        writer.ready()
        eventually(lambda: out.matched and slow.directory.leader("/test/out:o"))
        stopping = threading.Event()
        thread = threading.Thread(target=_write_until, args=(out, stopping))
        thread.start()
        first = last = eventually(inp.read).envelope.seq
        before = inp._samples.passed  # dropped before anything was read
        for _ in range(20):
            time.sleep(0.02)  # its work
            received = eventually(inp.newest)
            assert received.envelope.seq > last
            last = received.envelope.seq
        stopping.set()
        thread.join()
        statistics, passed = inp.statistics, inp._samples.passed - before
        assert statistics.received == 21
        assert statistics.received + passed + statistics.lost == last - first + 1
        assert passed > 0


def _write_until(out, stopping):
    while not stopping.wait(0.001):
        out.write(Number(value=1.0))


def test_readers_that_join_a_running_stream_hear_no_stranger(hub, writer):
    """Who owns the name is known before the first message."""
    out = writer.output("/test/out:o", Number, rate=1000.0)
    writer.ready()
    stopping = threading.Event()
    thread = threading.Thread(target=_write_until, args=(out, stopping))
    thread.start()
    try:
        for k in range(10):
            with Node(f"reader{k}", connect=hub, signals=False) as reader:
                inp = reader.input(f"/reader{k}/in:i", Number, source="/test/out:o", depth=64)
                reader.ready()
                eventually(lambda: inp.read())  # noqa: B023
                assert inp.statistics.foreign == 0
    finally:
        stopping.set()
        thread.join()
