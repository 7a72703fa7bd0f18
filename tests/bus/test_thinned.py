"""Thinned streams: 250 Hz of a faster output, for those who need no more."""

import pytest

from bus.introspection import port_info
from bus.testing import collect, eventually
from tests.bus.messages import MS, Number, write


@pytest.fixture
def thinned(writer, node):
    """Return an output of 1 kHz and a reader of its thinned stream."""
    out = writer.output("/w/x:o", Number, rate=1000.0)
    inp = node.input("/r/x:i", Number, source="/w/x:o", depth=64, rate=1000.0, stream="thinned")
    for each in (writer, node):
        each.ready()
    eventually(lambda: out.wanted(0) and node.directory.leader("/w/x:o"))
    return out, inp


def test_the_first_message_of_each_4_ms_arrives_numbered_without_gaps(thinned, node):
    out, inp = thinned
    write(out, range(0, 20 * MS, MS))
    got = collect(node, inp, 5)
    assert [r.data.value for r in got] == [0.0, 4.0, 8.0, 12.0, 16.0]
    assert [r.envelope.seq for r in got] == [1, 2, 3, 4, 5]
    assert inp.statistics.lost == inp.statistics.foreign == 0


def test_every_invalid_message_arrives(thinned, node):
    out, inp = thinned
    write(out, [8 * MS] * 3, valid=False, reason="no data")
    assert not any(r.envelope.valid for r in collect(node, inp, 3))


def test_stamps_that_jump_back_go_on(thinned, node):
    out, inp = thinned
    write(out, [9 * MS, 10 * MS, 2 * MS, 3 * MS])
    assert [r.data.value for r in collect(node, inp, 2)] == [9.0, 2.0]


def test_the_whole_stream_is_not_wanted_by_a_thinned_reader(thinned, node):
    out, inp = thinned
    write(out, [0])
    collect(node, inp, 1)
    assert not out.matched
    assert out.wanted(4 * MS) and out.wanted(MS, valid=False) and not out.wanted(MS)
    assert port_info(node, "/w/x:o")["wanted_hz"] == 250.0


def test_readers_of_both_kinds_get_theirs(thinned, node):
    out, inp = thinned
    whole = node.input("/r/whole:i", Number, source="/w/x:o", depth=64)
    eventually(lambda: out.matched)
    write(out, range(0, 8 * MS, MS))
    assert len(collect(node, whole, 8)) == 8
    assert len(collect(node, inp, 2)) == 2
    assert port_info(node, "/w/x:o")["wanted_hz"] == 1000.0


def test_a_thinned_input_is_listed_with_the_rate_that_it_gets(thinned, node):
    assert port_info(node, thinned[1].name)["nominal_hz"] == 250.0


def test_an_output_that_nobody_reads_is_not_wanted(writer, node):
    out = writer.output("/w/alone:o", Number, rate=1000.0)
    writer.ready()
    node.ready()
    assert not out.wanted(0)
    assert port_info(node, "/w/alone:o")["wanted_hz"] == 0.0
