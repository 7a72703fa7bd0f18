"""Bundled streams: every message, those of 4 ms at once."""

import pytest

from bus.introspection import port_info
from bus.packing import pack
from bus.testing import collect, eventually
from tests.bus.messages import MS, Number, write


@pytest.fixture
def bundled(writer, node):
    """Return an output of 1 kHz and a reader of its bundles."""
    out = writer.output("/w/x:o", Number, rate=1000.0)
    inp = node.input("/r/x:i", Number, source="/w/x:o", depth=64, polled=True, stream="bundled")
    for each in (writer, node):
        each.ready()
    eventually(lambda: out.matched and node.directory.leader("/w/x:o"))
    return out, inp


def test_every_message_arrives_in_order_with_the_first_of_the_next_4_ms(bundled, node):
    out, inp = bundled
    write(out, range(0, 9 * MS, MS))
    got = collect(node, inp, 9)
    assert [r.data.value for r in got] == [float(k) for k in range(9)]
    assert [r.envelope.seq for r in got] == list(range(1, 10))
    assert inp.statistics.lost == inp.statistics.refused == 0


def test_what_is_not_yet_bundled_waits(bundled, node):
    out, inp = bundled
    write(out, [0, MS, 2 * MS])
    assert collect(node, inp, 1)[0].data.value == 0.0
    control = node.input("/r/control:i", Number, source="/w/x:o", depth=8)
    eventually(lambda: out.write(Number(value=3.0), stamp=3 * MS) or control.read())
    assert inp.read() is None


def test_an_invalid_message_takes_those_before_it_along(bundled, node):
    out, inp = bundled
    write(out, [0, MS])
    write(out, [MS], valid=False, reason="no data")
    assert [r.envelope.valid for r in collect(node, inp, 3)] == [True, True, False]


def test_a_reader_of_bundles_wants_the_whole_rate(bundled, node):
    assert port_info(node, "/w/x:o")["wanted_hz"] == 1000.0


def test_the_next_reader_gets_nothing_that_waited_for_the_last_one(bundled, node):
    out, inp = bundled
    write(out, [0, MS])
    inp.rest(True)
    eventually(lambda: not out.matched)
    write(out, [2 * MS])
    inp.rest(False)
    eventually(lambda: out.matched)
    write(out, [4 * MS])
    eventually(lambda: (r := inp.newest()) and r.data.value == 4.0)
    assert inp.statistics.lost == 0 and inp.statistics.received in (1, 2)


def test_a_bundle_of_rubbish_is_refused(bundled, node):
    _, inp = bundled
    for payload in (b"", b"\xc1", pack([1, 2]), pack([b"rubbish", b""])):
        before = inp.statistics.refused
        node.session.put("@wb/bundled/w/x:o", payload)
        eventually(lambda before=before: inp.read() or inp.statistics.refused > before)


def test_only_a_polled_input_reads_bundles(node):
    with pytest.raises(ValueError, match="only a polled input"):
        node.input("/r/x:i", Number, source="/w/x:o", stream="bundled")
