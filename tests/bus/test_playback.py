"""Playing a recording: the schedule, the bytes, the clock, and who moves the position."""

import threading
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np
import pytest

from bus import NameTaken, Node
from bus.encoder import Encoder
from bus.envelope import envelope_of
from bus.recording import Recording, RecordingError, RecordingWriter
from bus.recording.heads import head_of, join, split
from bus.recording.playback import Playback, select_ports
from bus.recording.player import Player
from bus.recording.read_ahead import by_sent
from bus.recording.reader import Message
from bus.recording.timeline import Timeline
from bus.schema import fields_of, type_name
from bus.testing import collect, eventually
from tests.bus.messages import MS, Mixed, Number, mixed

SECOND = 1_000_000_000
START = 1_700_000_000 * SECOND  # wall time of the recordings


def info(kind: type, rate: float = 100.0) -> dict:
    fields = [field.describe() for field in fields_of(kind)]
    return {"type": type_name(kind), "fields": fields, "nominal_hz": rate}


def record(path: Path, seconds: float = 1.0) -> Recording:
    """Record two ports: a number each 10 ms, and every kind of field each 20 ms."""
    writer = RecordingWriter(path, {})
    number, other = (
        writer.open_channel("/toy/number:o", info(Number)),
        writer.open_channel("/toy/mixed:o", info(Mixed, 50.0)),
    )
    numbers, others = Encoder(Number, bytes(16)), Encoder(Mixed, bytes(range(16)), model="toy")
    for i in range(round(seconds * 100)):
        stamp, sent = (i + 1) * 10 * MS, START + i * 10 * MS
        times = (i + 1, stamp, 1, sent - MS, sent)
        data = numbers.encode(Number(value=float(i)), *times)
        writer.write(number, data, envelope_of(data), sent + 5 * MS)
        if i % 2 == 0:
            data = others.encode(mixed(), *times, i % 4 == 0, "" if i % 4 == 0 else "odd")
            writer.write(other, data, envelope_of(data), sent + 20 * MS)
    writer.close()
    return Recording(path)


@pytest.fixture
def tape(tmp_path: Path) -> Recording:
    return record(tmp_path / "toy.mcap")


@contextmanager
def playing(hub: str, tape: Recording, *ports: str, prefix: str = "", **settings) -> Iterator:
    """Play in a thread; yields the player's service name after everything stands."""
    chosen = select_ports(tape, ports)
    player = Player(tape, chosen, paused=True, **settings)
    ended, ready, failed = threading.Event(), threading.Event(), []

    def run() -> None:
        try:
            with Node("player", connect=hub, signals=False) as node:
                playback = Playback(node, player, chosen, prefix)
                node.ready()
                ready.set()
                while not ended.is_set():
                    playback.spin()
        except Exception as error:
            failed.append(error)
            ready.set()

    thread = threading.Thread(target=run)
    thread.start()
    try:
        assert ready.wait(20.0)
        if failed:
            raise failed[0]
        yield player
    finally:
        ended.set()
        thread.join()
        player.close()


def ask(node: Node, verb: str, **arguments):
    return node.call("/player/rpc:i", verb, arguments)


# -- the schedule


def test_a_schedule_does_not_drift():
    timeline = Timeline(0, rate=0.3)
    timeline.run(1000)
    for now in range(1000, 10_000_000_000, 12_345_677):  # thousands of looks change nothing
        timeline.note(timeline.position(now), now)
    assert timeline.position(1000 + 100 * SECOND) == 30 * SECOND
    assert timeline.slipped == 0


def test_pauses_and_rates_change_the_pace_and_not_the_position():
    timeline = Timeline(5 * SECOND)
    timeline.run(0)
    timeline.pause(SECOND)
    assert timeline.position(9 * SECOND) == 6 * SECOND
    timeline.change_rate(2.0, 9 * SECOND)
    assert timeline.position(9 * SECOND) == 6 * SECOND
    timeline.run(9 * SECOND)
    assert timeline.position(10 * SECOND) == 8 * SECOND
    assert timeline.remaining(9 * SECOND, 10 * SECOND) == SECOND // 2


def test_after_a_stall_of_the_machine_the_rest_is_given_up_and_counted():
    timeline = Timeline(0)
    timeline.run(0)
    timeline.note(0, 5 * SECOND)
    assert timeline.slipped == 5 * SECOND
    assert timeline.position(5 * SECOND) == 0


def test_messages_are_played_in_the_order_in_which_they_were_sent(tape: Recording):
    sent = [item.message.sent for item in by_sent(tape.messages())]
    assert len(sent) == 150 and sent == sorted(sent)
    arrived = [message.envelope.sent for message in tape.messages()]
    assert arrived != sorted(arrived)


# -- the bytes


def test_only_the_head_of_a_message_is_new(tape: Recording):
    for message in tape.messages():
        taken = split(message.data)
        ours = join(head_of(message.envelope.type, b"x" * 16, 3), 7, *taken[:3], 99, taken.tail)
        old, new = envelope_of(message.data), envelope_of(ours)
        assert new == old._replace(source=b"x" * 16, epoch=3, seq=7, sent=99)
        assert len(ours) == len(message.data) and ours.endswith(taken.tail)


def test_another_encoders_form_is_understood():
    import msgpack

    message = ["Number/1", bytes(16), 0, 1, 5, 1, 6, 7, True, "", "", {"value": 1.0}, [], b""]
    taken = split(msgpack.packb(message))
    assert taken[:5] == (5, 1, 6, 7, True)
    ours = join(head_of("Number/1", bytes(16), 2), 9, *taken[:3], 8, taken.tail)
    assert msgpack.unpackb(ours) == [*message[:2], 2, 9, 5, 1, 6, 8, *message[8:]]


def test_what_is_no_message_is_left_out():
    spoilt = [Message("/toy/number:o", data, 0) for data in (b"", b"\x9e", b"nonsense" * 20)]
    assert list(by_sent(spoilt)) == []


def test_readers_get_the_recorded_data_under_the_players_own_source(
    hub: str, node: Node, tape: Recording
):
    numbers = node.input("/test/number:i", Number, "/toy/number:o", depth=256)
    others = node.input("/test/mixed:i", Mixed, "/toy/mixed:o", depth=256)
    node.ready()
    with playing(hub, tape, rate=10.0):
        eventually(lambda: node.directory.leader("/toy/mixed:o"))
        ask(node, "seek", time=0.0)
        received = {m.envelope.stamp: m for m in _until_end(node, numbers)}
        assert [m.data.value for m in received.values()][:10] == list(map(float, range(10)))
        leader = node.directory.leader("/toy/number:o")
        assert {m.envelope.source for m in received.values()} == {leader} != {bytes(16)}
        old = {m.envelope.stamp: m.envelope for m in tape.messages(["/toy/number:o"])}
        for stamp, message in received.items():
            ours, theirs = message.envelope, old[stamp]
            assert ours.acquired == theirs.acquired and ours.sent > theirs.sent
        first = others.read()
        assert first is not None and first.envelope.model == "toy"
        np.testing.assert_array_equal(first.data.ft, mixed().ft)
        second = others.read()
        assert second is not None and not second.envelope.valid
        assert second.envelope.reason == "odd"


def _until_end(node: Node, port) -> list:
    """Play from the start, and return what came until the player says that it is at the end."""
    messages = []

    def over() -> bool:
        node.wait(0.01)
        while (received := port.read()) is not None:
            messages.append(received)
        return ask(node, "status")["ended"]

    ask(node, "resume")
    eventually(over)
    return messages


def test_with_a_prefix_the_recorded_robot_stands_beside_the_live_one(
    hub: str, node: Node, writer: Node, tape: Recording
):
    live = writer.output("/toy/number:o", Number)
    writer.ready()
    port = node.input("/test/number:i", Number, "/log/toy/number:o", depth=256)
    node.ready()
    with playing(hub, tape, "/toy/number:o", prefix="/log", loop=True) as player:
        live.write(Number(value=-1.0))
        player.resume()
        assert all(m.data.value >= 0.0 for m in collect(node, port, 10))


def test_names_that_somebody_has_are_refused(hub: str, writer: Node, tape: Recording):
    writer.output("/toy/number:o", Number)
    writer.ready()
    with pytest.raises(NameTaken, match="/toy/number:o is taken"):
        with playing(hub, tape):
            pass


def test_an_unknown_port_is_named_with_what_exists(tape: Recording):
    with pytest.raises(RecordingError, match="did you mean /toy/number:o"):
        select_ports(tape, ["/toy/nmber:o"])
    assert list(select_ports(tape, ["/toy/m*"])) == ["/toy/mixed:o"]


@pytest.mark.parametrize(("begin", "end"), [(5.0, None), (0.5, 0.2), (-1.0, None)])
def test_a_part_that_the_recording_does_not_have_is_refused(tape: Recording, begin, end):
    with pytest.raises(RecordingError, match="expected from < to within its 1.0"):
        Player(tape, ["/toy/number:o"], begin=begin, end=end)


# -- the clock, and who moves it


def test_a_part_is_played_and_nothing_else(tape: Recording):
    player = Player(tape, ["/toy/number:o"], rate=None, begin=0.3, end=0.5)
    sent = []

    def ended() -> bool:
        if (item := player.next()) is not None:
            sent.append((item.message.sent - tape.start) * 1e-9)
        return player.ended

    eventually(ended)
    assert 0.3 <= sent[0] < 0.32 and 0.48 < sent[-1] < 0.5
    assert player.paused and player.status()["position"] == 0.5
    player.resume()  # from the beginning of the part
    eventually(ended)
    assert player.jumps == 1 and len(sent) == 40


def test_readers_follow_the_clock_of_the_file(hub: str, node: Node, tape: Recording):
    node.follow_clock("/toy/clock:o")
    node.ready()
    with playing(hub, tape, rate=0.1):
        ask(node, "resume")
        eventually(_looking(node, lambda: node.clock.state == "running"))
        eventually(_looking(node, lambda: node.clock.time >= 50 * MS))
        ask(node, "pause")
        eventually(_looking(node, lambda: node.clock.state == "paused"))
        stood = node.clock.time
        ask(node, "step", seconds=0.1)
        eventually(_looking(node, lambda: node.clock.time >= stood + 80 * MS))
        eventually(_looking(node, lambda: node.clock.state == "paused"))
        assert node.clock.resets == 0
        ask(node, "seek", time=0.0)  # backwards is a reset
        eventually(_looking(node, lambda: node.clock.resets == 1))
        assert node.clock.time < stood
        ask(node, "rate", value=50.0)
        ask(node, "resume")
        eventually(_looking(node, lambda: ask(node, "status")["ended"]))
        eventually(_looking(node, lambda: node.clock.time == 1000 * MS))
        eventually(_looking(node, lambda: node.clock.state == "paused"))


def _looking(node: Node, predicate: Callable[[], bool]) -> Callable[[], bool]:
    """Let the node hear of the bus before each look."""

    def look() -> bool:
        node.wait(0.01)
        return predicate()

    return look


def test_a_loop_begins_again_and_is_a_reset(hub: str, node: Node, tape: Recording):
    node.follow_clock("/toy/clock:o")
    node.ready()
    with playing(hub, tape, rate=5.0, loop=True) as player:
        ask(node, "resume")
        eventually(_looking(node, lambda: player.jumps >= 2))
        eventually(_looking(node, lambda: node.clock.resets >= 2))
        assert not player.paused


def test_a_wrong_request_is_refused_with_what_is_expected(hub: str, node: Node, tape: Recording):
    node.ready()
    with playing(hub, tape):
        with pytest.raises(Exception, match="rate must lie between"):
            ask(node, "rate", value=0.0)
        with pytest.raises(Exception, match="seconds must lie between"):
            ask(node, "step", seconds=-1.0)
