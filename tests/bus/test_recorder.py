"""The recorder on a bus: nothing is lost unseen."""

import signal
import time

import pytest

from bus import Node
from bus.packing import pack
from bus.recording import Recording, RecordingWriter
from bus.recording.recorder import Recorder
from bus.testing import eventually
from tests.bus.messages import MS, Mixed, Number, mixed, write
from tests.bus.recordings import Source


@pytest.fixture
def record(node, tmp_path):
    """Return ``record(*ports)``, which starts a recorder whose file is `path`."""
    node.ready()
    started = []

    def begin(*ports, **more):
        writer = RecordingWriter(tmp_path / "a.mcap", {"version": "1"})
        started.append(Recorder(node, writer, ports, **more))
        return started[-1]

    yield begin
    for recorder in started:
        recorder.abandon()


def until(recorder, ports=(), count=1):
    """Step until so many messages of each port are recorded."""

    def enough():
        recorder.step()
        losses = recorder.writer.losses
        return all(p in losses and losses[p].recorded >= count for p in ports)

    eventually(enough, what=f"{count} of {ports}")


def finish(recorder):
    """Close a recorder; return its recording."""
    recorder.close()
    return Recording(recorder.writer.path)


def test_fast_slow_and_direct_messages_are_recorded_whole(record, writer, node):
    fast = writer.output("/w/fast:o", Number, rate=1000.0)
    slow = writer.output("/w/slow:o", Number)
    writer.input("/w/in:i", Number)
    direct = writer.output("/w/in:i", Number)
    writer.ready()
    names = "/w/fast:o", "/w/slow:o", "/w/in:i"
    eventually(lambda: set(names) <= set(node.directory.names()))  # with the rate of the fast one
    recorder = record(*names)
    eventually(lambda: fast.matched and slow.matched and direct.matched)
    for first in range(0, 40, 8):  # of more at once a busy link may drop some
        for out in (fast, slow, direct):
            write(out, range(first * MS, (first + 8) * MS, MS))
        until(recorder, names[1:], first + 8)
    write(fast, [40 * MS])
    until(recorder, names, 40)
    recording = finish(recorder)
    for name in recording.ports:
        values = [m.envelope.seq for m in recording.messages([name])]
        assert values == list(range(1, len(values) + 1))
        assert recording.metadata[f"losses{name}"]["lost"] == "0"
    assert recording.ports["/w/slow:o"].count == recording.ports["/w/in:i"].count == 40
    assert recording.ports["/w/in:i"].direction == "input"


def test_all_but_the_excluded_and_those_that_appear_later_are_recorded(record, writer, node):
    early = writer.output("/w/early:o", Number)
    view = writer.output("/w/arm/state:o", Number)
    writer.ready()
    eventually(lambda: "/w/arm/state:o" in node.directory.names())
    recorder = record(exclude=["/*/*/state:o"])
    late = writer.output("/w/late:o", Mixed, dimensions={"n": 3, "k": 2})
    eventually(lambda: recorder.step() or (early.matched and late.matched))
    assert not view.matched
    write(early, [0])
    late.write(mixed())
    until(recorder, ["/w/early:o", "/w/late:o"])
    recording = finish(recorder)
    assert {"/w/early:o", "/w/late:o"} <= set(recording.ports)
    assert "/w/arm/state:o" not in recording.ports
    assert [field["name"] for field in recording.ports["/w/late:o"].fields][:2] == ["q", "ft"]


def test_a_writer_that_is_stopped_holds_up_nobody_else(record, start, writer, node):
    start("tests.bus.source")
    stopped = start("tests.bus.source", "--name", "stopped")
    stopped.send(signal.SIGSTOP)
    began = time.monotonic()
    recorder = record("/source/out:o", "/stopped/out:o")
    longest = 0.0

    def flows():
        nonlocal began, longest
        longest, began = max(longest, time.monotonic() - began), time.monotonic()
        recorder.step()
        return "/source/out:o" in recorder.writer.losses

    eventually(flows)
    until(recorder, ["/source/out:o"], 50)
    assert longest < 1.5  # it does not wait for who does not answer
    stopped.send(signal.SIGCONT)
    until(recorder, ["/stopped/out:o"], 10)
    recording = finish(recorder)
    assert recording.ports["/stopped/out:o"].fields  # told late, but told


def test_a_writer_that_is_killed_and_replaced_is_recorded_on(record, start, node):
    first = start("tests.bus.source")
    recorder = record("/source/out:o")
    until(recorder, ["/source/out:o"], 20)
    first.kill()
    start("tests.bus.source")
    before = recorder.writer.losses["/source/out:o"].recorded
    until(recorder, ["/source/out:o"], before + 40)
    losses = recorder.writer.losses["/source/out:o"]
    recording = finish(recorder)
    envelopes = [m.envelope for m in recording.messages()]
    assert losses.sources == 2 and losses.unheard == losses.foreign == 0
    assert envelopes[-1].source != envelopes[0].source
    again = [e.seq for e in envelopes if e.source == envelopes[-1].source]
    assert again[0] == 1 and again == sorted(set(again))  # from its very first message
    assert len(recording.channels) == 1


def test_a_port_that_changes_its_type_is_recorded_as_both(record, hub, node):
    recorder = record("/w/x:o")
    for kind, data in ((Number, Number(value=1.0)), (Mixed, mixed())):
        with Node("writer", connect=hub, signals=False) as writer:
            out = writer.output("/w/x:o", kind, dimensions={"n": 3, "k": 2})
            writer.ready()
            eventually(lambda out=out: recorder.step() or out.matched)
            before = recorder.writer.losses.get("/w/x:o")
            count = before.recorded if before else 0
            out.write(data)
            until(recorder, ["/w/x:o"], count + 1)
    recording = finish(recorder)
    assert [(p.type, p.count) for p in recording.channels] == [("Number/1", 1), ("Mixed/1", 1)]
    assert [m.envelope.type for m in recording.messages()] == ["Number/1", "Mixed/1"]


def test_what_is_no_message_or_of_a_stranger_is_counted_and_left_out(record, writer, node):
    out = writer.output("/w/x:o", Number)
    writer.ready()
    eventually(lambda: "/w/x:o" in node.directory.names())
    recorder = record("/w/x:o")
    eventually(lambda: out.matched)
    write(out, [0])
    writer.session.put("w/x:o", pack("nonsense"))
    stranger = writer.session.declare_publisher("w/x:o")
    until(recorder, ["/w/x:o"], 1)
    stranger.put(Source().message())
    losses = recorder.writer.losses["/w/x:o"]
    eventually(lambda: recorder.step() or (losses.refused and losses.foreign))
    recording = finish(recorder)
    assert recording.ports["/w/x:o"].count == 1
    assert recording.metadata["losses/w/x:o"]["foreign"] == "1"


def test_what_was_written_last_and_did_not_come_is_lost(record, writer, node):
    out = writer.output("/w/x:o", Number)
    writer.ready()
    eventually(lambda: "/w/x:o" in node.directory.names())
    recorder = record("/w/x:o")
    eventually(lambda: out.matched)
    write(out, [0])
    until(recorder, ["/w/x:o"], 1)
    out.statistics.written += 7  # as if the link had swallowed them
    assert finish(recorder).metadata["losses/w/x:o"]["lost"] == "7"


@pytest.mark.parametrize("rate", [1000.0, 0.0])
def test_the_last_messages_of_a_writer_that_ends_are_recorded(record, hub, node, rate):
    with Node("writer", connect=hub, signals=False) as writer:
        out = writer.output("/w/x:o", Number, rate=rate)
        writer.ready()
        eventually(lambda: "/w/x:o" in node.directory.names())
        recorder = record("/w/x:o")
        eventually(lambda: out.matched)
        write(out, range(0, 7 * MS, MS))  # the last ones lie in an open bundle
    until(recorder, ["/w/x:o"], 7)
    assert finish(recorder).metadata["losses/w/x:o"]["lost"] == "0"
