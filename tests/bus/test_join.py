"""In lockstep streams are joined by stamp, whatever arrives first."""

import threading
from unittest import mock

import pytest

from bus import Node
from bus.lockstep import Join
from bus.testing import eventually
from tests.bus.messages import MS, Number, write


@pytest.fixture
def pair(hub: str, writer: Node):
    """Return a participant's input with its join, and who writes to it at 250 Hz."""
    with Node("reader", connect=hub, lockstep=True, signals=False) as node:
        out = writer.output("/toy/base:o", Number, rate=250.0)
        port = node.input("/reader/base:i", Number, "/toy/base:o", rate=250.0)
        writer.ready()
        node.ready()
        eventually(lambda: out.matched and node.directory.leader("/toy/base:o"))
        yield port, Join(node, [port]), out


def need_not_wait(join: Join, stamp: int) -> None:
    """Join at a stamp; fail when that waits."""
    with mock.patch.object(join._node, "wait", side_effect=AssertionError("waits")):
        join.wait(stamp)


def test_a_join_waits_for_the_message_that_is_due_at_a_stamp(pair):
    port, join, out = pair
    write(out, [4 * MS])
    late = threading.Timer(0.2, write, (out, [8 * MS]))
    late.start()
    join.wait(10 * MS)  # 8 ms is the last that a writer of 250 Hz has by then
    assert port.latest.envelope.stamp == 8 * MS
    late.join()


def test_a_stamp_between_two_messages_is_not_waited_for(pair):
    port, join, out = pair
    write(out, [8 * MS])
    join.wait(9 * MS)
    need_not_wait(join, 11 * MS)
    assert port.latest.envelope.stamp == 8 * MS


def test_after_a_reset_the_messages_of_the_former_run_do_not_count(pair):
    port, join, out = pair
    write(out, [400 * MS])
    join.wait(400 * MS)
    late = threading.Timer(0.2, write, (out, [4 * MS]))
    late.start()
    join.wait(5 * MS)
    assert port.latest.envelope.stamp == 4 * MS
    late.join()


def test_what_was_said_before_the_first_tick_does_not_count(pair):
    port, join, out = pair
    out.write(Number(value=0.0), stamp=0, valid=False, reason="no data yet")
    eventually(lambda: port.newest() is not None)
    late = threading.Timer(0.2, write, (out, [1 * MS]))
    late.start()
    join.wait(1 * MS)
    assert port.latest.envelope.stamp == 1 * MS
    late.join()


def test_who_has_no_measurement_speaks_of_the_last_stamp_that_was_done(hub: str):
    with Node("participant", connect=hub, lockstep=True, signals=False) as node:
        out = node.output("/participant/x:o", Number)
        port = node.input("/participant/x:i", Number, "/participant/x:o", depth=4)
        node.ready()
        out.write(Number(value=0.0))
        node.acknowledge(3 * MS)
        out.write(Number(value=0.0))
        assert [eventually(port.read).envelope.stamp for _ in range(2)] == [0, 3 * MS]


def test_a_writer_that_does_not_take_part_is_named_once_and_not_waited_for_again(pair, caplog):
    port, join, out = pair
    join.wait(4 * MS)
    need_not_wait(join, 8 * MS)
    assert caplog.text.count("/reader/base:i: nothing for 4000000 ns") == 1
    assert len(caplog.records) == 1


def test_what_nobody_writes_is_not_waited_for(hub: str):
    with Node("reader", connect=hub, lockstep=True, signals=False) as node:
        port = node.input("/reader/base:i", Number, "/toy/nobody:o", rate=250.0)
        node.ready()
        need_not_wait(Join(node, [port]), 4 * MS)
        assert port.latest is None
