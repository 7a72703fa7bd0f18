"""Outputs and inputs over a hub."""

import os
import threading
import time
from dataclasses import asdict

import numpy as np
import pytest

from bus import BusError, NameTaken, Node, WireError
from bus.counters import InputStatistics
from bus.encoder import Encoder
from bus.introspection import list_ports, list_services, port_info, wait_for_port, wait_for_service
from bus.testing import collect, eventually
from tests.bus.messages import Mixed, Number, mixed


def join(*nodes):
    for node in nodes:
        node.ready()


def pair(writer, node, depth=64, **more):
    out = writer.output("/w/x:o", Number, rate=100.0)
    inp = node.input("/r/x:i", Number, source="/w/x:o", depth=depth, **more)
    join(writer, node)
    eventually(lambda: out.matched and node.directory.leader("/w/x:o"))
    return out, inp


def test_messages_arrive_in_order_with_their_envelope(writer, node):
    out, inp = pair(writer, node)
    got = []
    for k in range(50):
        out.write(Number(value=float(k)), stamp=1000 + k, clock=1, acquired=77)
        got += collect(node, inp, 1)
    assert [r.data.value for r in got] == [float(k) for k in range(50)]
    assert [r.envelope.seq for r in got] == list(range(1, 51))
    envelope = got[0].envelope
    assert (envelope.stamp, envelope.clock, envelope.acquired) == (1000, 1, 77)
    assert envelope.source == out.source and envelope.valid
    assert inp.latest is got[-1]
    assert inp.statistics.as_map() == asdict(InputStatistics(received=50))


@pytest.mark.parametrize("reliable", [False, True], ids=["state", "command"])
def test_messages_that_are_written_at_once_are_all_read_in_order(writer, node, reliable):
    out = writer.output("/w/x:o", Number, reliable=reliable)
    inp = node.input("/r/x:i", Number, source="/w/x:o", depth=64)
    join(writer, node)
    eventually(lambda: out.matched and node.directory.leader("/w/x:o"))
    for k in range(10):
        out.write(Number(value=float(k)))
    assert [r.data.value for r in collect(node, inp, 10)] == [float(k) for k in range(10)]
    assert inp.statistics.lost == inp.statistics.dropped == 0


@pytest.mark.parametrize("stream", ["whole", "bundled"])
def test_what_a_writer_does_to_its_data_afterwards_does_not_reach_the_reader(writer, node, stream):
    out = writer.output("/w/x:o", Mixed)
    inp = node.input("/r/x:i", Mixed, "/w/x:o", depth=8, polled=True, stream=stream)
    join(writer, node)
    eventually(lambda: out.matched and node.directory.leader("/w/x:o"))
    message = mixed(tags=["before"])
    for stamp in (1, 2, 10_000_000):  # in a bundle the second one waits
        out.write(message, stamp=stamp)
        message.q[:] += 10.0
        message.tags[0] += "!"
    got = collect(node, inp, 3)
    assert [r.data.q[0] for r in got] == [0.0, 10.0, 20.0]
    assert [r.data.tags for r in got] == [["before"], ["before!"], ["before!!"]]


def test_what_derives_from_a_message_keeps_its_times(writer, node):
    out, inp = pair(writer, node)
    out.write(Number(value=1.0), stamp=5, clock=1, acquired=6)
    first = collect(node, inp, 1)[0].envelope
    out.write(Number(value=2.0), like=first, valid=False, reason="no data")
    second = collect(node, inp, 1)[0].envelope
    assert (second.stamp, second.clock, second.acquired) == (5, 1, 6)
    assert (second.valid, second.reason) == (False, "no data")


def test_a_message_on_a_port_that_does_not_wake_waits_to_be_read(writer, node):
    out, inp = pair(writer, node, wakes=False)
    while node.wait(0.05):
        pass  # what the opening of the ports left
    out.write(Number(value=1.0))
    assert not node.wait(0.3)
    received = eventually(inp.read)
    assert received.data.value == 1.0


def test_newest_only_keeps_one_and_counts_the_rest(writer, node):
    out, inp = pair(writer, node, depth=1)
    for k in range(8):
        out.write(Number(value=float(k)))
    eventually(lambda: inp._samples._items and inp._samples.dropped == 7, what="all arrived")
    assert inp.newest().data.value == 7.0
    assert inp.newest() is None
    assert (inp.statistics.dropped, inp.statistics.lost) == (7, 0)
    for k in range(8):
        out.write(Number(value=float(k)))
    eventually(lambda: inp._samples.dropped == 14)
    inp.newest()
    assert (inp.statistics.dropped, inp.statistics.lost) == (14, 0)


def test_a_bounded_queue_drops_the_oldest(writer, node):
    out, inp = pair(writer, node, depth=4)
    for k in range(10):
        out.write(Number(value=float(k)))
    eventually(lambda: inp._samples.dropped == 6)
    assert [r.data.value for r in collect(node, inp, 4)] == [6.0, 7.0, 8.0, 9.0]


def test_losses_on_the_wire_are_counted_for_each_writer_by_itself(writer, node):
    inp = node.input("/r/y:i", Number, depth=64)
    join(node)
    one, two = (Encoder(Number, bytes([k]) * 16) for k in (1, 2))
    publisher = writer.session.declare_publisher("r/y:i")
    eventually(lambda: publisher.matching_status.matching)
    for who, seq in [(one, 1), (two, 100), (one, 2), (two, 103), (one, 5), (two, 104), (one, 5)]:
        publisher.put(who.encode(Number(value=1.0), seq, 0, 0, 0, 0))
    collect(node, inp, 6)
    eventually(lambda: inp.read() is None and inp.statistics.repeated == 1)
    assert inp.statistics.lost == 4  # 2 of each
    assert inp.statistics.received == 6


def test_anybody_may_write_directly_to_an_input(writer, node):
    inp = node.input("/r/command:i", Number, source="/nobody:o", depth=8)
    join(node)
    direct = writer.output("/r/command:i", Number)
    eventually(lambda: direct.matched)
    direct.write(Number(value=4.0))
    assert collect(node, inp, 1)[0].data.value == 4.0
    assert writer.ports.get("/r/command:i") is None


def test_only_the_owner_of_a_name_is_heard_on_it(writer, node):
    out, inp = pair(writer, node)
    stranger = writer.session.declare_publisher("w/x:o")
    forged = Encoder(Number, os.urandom(16)).encode(Number(value=9.0), 1, 0, 0, 0, 0)
    stranger.put(forged)
    out.write(Number(value=1.0))
    assert [r.data.value for r in collect(node, inp, 1)] == [1.0]
    eventually(lambda: inp.read() is None and inp.statistics.foreign == 1)


BAD = {
    "garbage": b"\xc1\x00garbage",
    "nothing": b"",
    "another type": Encoder(Number, bytes(16)).encode(Number(value=1.0), 1, 0, 0, 0, 0),
    "another shape": Encoder(Mixed, bytes(16), 0, "m").encode(mixed(4), 1, 0, 0, 0, 0),
    "another robot": Encoder(Mixed, bytes(16), 0, "x").encode(mixed(), 1, 0, 0, 0, 0),
    "too long": bytes(70_000),
    "far too long": bytes(3 << 20),
    "NaN": Encoder(Mixed, bytes(16), 0, "m")
    .encode(mixed(), 1, 0, 0, 0, 0)
    .replace(np.float64(2.0).tobytes(), np.float64(np.nan).tobytes()),
}


@pytest.mark.parametrize("bad", BAD.values(), ids=BAD.keys())
def test_a_bad_message_changes_nothing_but_a_counter(writer, node, bad, caplog):
    inp = node.input("/r/z:i", Mixed, depth=64, model="m", dimensions={"n": 3, "k": 2})
    join(node)
    publisher = writer.session.declare_publisher("r/z:i")
    eventually(lambda: publisher.matching_status.matching)
    good, began = Encoder(Mixed, os.urandom(16), 0, "m"), time.monotonic()
    for seq in (1, 2):
        publisher.put(good.encode(mixed(), seq, 0, 0, 0, 0))
        publisher.put(bad)
    assert len(collect(node, inp, 2)) == 2
    eventually(lambda: inp.read() is None and inp.statistics.refused == 2)
    assert inp.statistics.lost == 0
    said = [record for record in caplog.records if "/r/z:i: message refused" in record.getMessage()]
    assert 1 <= len(said) <= 1 + int(time.monotonic() - began), "once per second at most"


def test_nothing_is_written_before_the_claim_stands(writer):
    out = writer.output("/w/x:o", Number)
    with pytest.raises(BusError, match="before node.ready"):
        out.write(Number(value=1.0))


def test_a_wrong_datum_is_refused_at_the_writer_and_takes_no_number(writer, node):
    out, inp = pair(writer, node)
    with pytest.raises(WireError, match="field value: expected a finite number"):
        out.write(Number(value=float("nan")))
    with pytest.raises(WireError, match="expected a message of type Number, got Mixed"):
        out.write(mixed())
    out.write(Number(value=1.0))
    assert collect(node, inp, 1)[0].envelope.seq == 1


def test_a_message_above_the_limit_is_refused_at_the_writer(writer, node):
    out = writer.output("/w/long:o", Mixed, max_message=1000)
    join(writer)
    with pytest.raises(WireError, match="limit 1000"):
        out.write(mixed(n=200))


def test_a_stream_is_fresh_until_it_stops_and_again_when_it_goes_on(writer, node):
    out, inp = pair(writer, node, rate=100.0)
    assert not inp.fresh and inp.reason == "no data on /w/x:o yet"

    def flows():
        out.write(Number(value=1.0))
        eventually(inp.newest)
        return inp.fresh and not inp.reason

    eventually(flows)
    eventually(lambda: inp.silence > 0.1)
    assert not inp.fresh
    eventually(lambda: inp.reason.startswith("no data on /w/x:o for "))
    eventually(flows)


def test_the_reason_tells_when_nobody_has_the_name(node):
    inp = node.input("/r/x:i", Number, source="/w/gone:o", rate=100.0)
    assert inp.reason == "nobody writes /w/gone:o"


def test_a_port_opened_later_claims_its_name_at_once(writer, node):
    join(writer, node)
    out = writer.output("/w/late:o", Number)
    inp = node.input("/r/late:i", Number, source="/w/late:o", depth=8)
    eventually(lambda: out.matched and node.directory.leader("/w/late:o"))
    out.write(Number(value=3.0))
    assert collect(node, inp, 1)[0].data.value == 3.0


def test_one_process_cannot_open_a_name_twice(writer):
    writer.output("/w/x:o", Number)
    with pytest.raises(NameTaken, match="open already in this process"):
        writer.output("/w/x:o", Number)


def test_all_ports_of_a_node_are_claimed_together(writer):
    ports = [writer.output(f"/w/x{k}:o", Number) for k in range(30)]
    assert not any(port.standing for port in ports)
    writer.ready()
    assert all(port.standing for port in ports)


def test_ports_and_services_are_listed(writer, node):
    pair(writer, node)
    wait_for_service(node, "writer")
    ports = {port["name"]: port for port in list_ports(node)}
    assert ports["/w/x:o"]["type"] == "Number/1"
    assert ports["/w/x:o"]["nominal_hz"] == 100.0
    assert ports["/w/x:o"]["owner"] == {
        **{"service": "writer", "pid": os.getpid(), "host": ports["/w/x:o"]["owner"]["host"]}
    }
    assert ports["/r/x:i"]["sources"] == ["/w/x:o"]
    assert ports["/writer/rpc:i"]["direction"] == "rpc"
    assert {"writer", "test", "hub"} <= {entry["service"] for entry in list_services(node)}


def test_the_information_of_a_port_has_fields_and_statistics(writer, node):
    out, inp = pair(writer, node)
    out.write(Number(value=1.0))
    collect(node, inp, 1)
    info = port_info(node, "/w/x:o")
    assert info["fields"][0] == {
        **{"name": "value", "type": "float", "shape": [], "unit": "m", "frame": ""},
        "optional": False,
        "required": True,
    }
    assert info["description"] == "One number."
    assert info["statistics"]["written"] == 1
    assert port_info(writer, "/r/x:i")["statistics"]["received"] == 1
    assert "help()" in port_info(node, "/writer/rpc:i")["verbs"]


def test_an_unknown_port_is_answered_with_near_names(writer, node):
    pair(writer, node)
    with pytest.raises(BusError, match=r"unknown port /w/y:o \(did you mean .*/w/x:o"):
        wait_for_port(node, "/w/y:o", timeout=0.05)
    with pytest.raises(BusError, match="service nobody is not ready.*ready are: .*writer"):
        wait_for_service(node, "nobody", timeout=0.05)


@pytest.mark.parametrize("polled", [False, True])
def test_what_a_writer_wrote_before_it_left_is_read(writer, node, polled):
    out, inp = pair(writer, node, polled=polled)
    out.write(Number(value=-1.0))
    collect(node, inp, 1)
    for k in range(10):
        out.write(Number(value=float(k)))
    control = node.input("/r/control:i", Number, source="/w/x:o")
    eventually(lambda: out.write(Number(value=10.0)) or control.read())
    writer.close()
    eventually(lambda: node.directory.owner("/w/x:o") is None)
    assert [r.data.value for r in collect(node, inp, 11)] == [float(k) for k in range(11)]
    assert inp.statistics.foreign == 0


def test_a_polled_input_has_no_thread_and_reads_what_waits_in_order(writer, node):
    threads = set(threading.enumerate())
    out, inp = pair(writer, node, polled=True)
    assert {t.name for t in set(threading.enumerate()) - threads} <= {"reunion"}
    for k in range(10):
        out.write(Number(value=float(k)))
        eventually(lambda k=k: (r := inp.read()) and r.data.value == float(k))
    assert inp.statistics.received == 10 and inp.fresh


def test_a_polled_input_counts_what_newer_messages_have_pushed_out_as_dropped(writer, node):
    out, inp = pair(writer, node, depth=2, polled=True)
    control = node.input("/r/control:i", Number, source="/w/x:o", depth=64)
    written = 0
    for _ in range(3):
        for _ in range(8):
            out.write(Number(value=0.0))
            collect(node, control, 1)
            written += 1
        assert inp.newest().envelope.seq == written
    statistics = inp.statistics
    assert (statistics.received, statistics.dropped, statistics.lost) == (6, 12, 0)


def test_a_resting_input_leaves_its_source_unmatched_and_counts_nothing_as_lost(writer, node):
    out, inp = pair(writer, node, polled=True)
    out.write(Number(value=0.0))
    collect(node, inp, 1)
    inp.rest(True)
    eventually(lambda: not out.matched)
    for k in range(5):
        out.write(Number(value=float(k)))
    with Node("direct", connect=node.endpoint, signals=False) as direct:
        own = direct.output("/r/x:i", Number)
        eventually(lambda: own.write(Number(value=7.0)) or inp.read())
    for _ in range(2):  # the second time there is nothing to resume
        inp.rest(False)
    eventually(lambda: out.matched)
    out.write(Number(value=9.0))
    eventually(lambda: (r := inp.read()) and r.data.value == 9.0)
    assert inp.statistics.lost == inp.statistics.dropped == 0
