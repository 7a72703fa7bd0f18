"""Connections are changed at run time by anybody, and those that are wished for good come back."""

import contextlib
import json
import threading

import pytest

from bus import BusError, Node
from bus.errors import RpcAbsent, RpcError
from bus.testing import eventually, running_hub
from bus.wiring import Connection, connect, connections, disconnect, forget
from bus.wishes import Wishes
from tests.bus.messages import Mixed, Number

TOY = "tests.bus.toys"
SINK = "/toy/in:i"


@contextlib.contextmanager
def writing(hub, name="/other/out:o", message=Number):
    """A place on the bus with one output that stands."""
    with Node("writer", connect=hub, signals=False) as opened:
        out = opened.output(name, message)
        opened.ready()
        yield out


def doubled(node, out, inp, value):
    """Write a number until its double comes out of the toy."""

    def came():
        out.write(Number(value=value))
        node.wait(0.01)
        received = inp.newest()
        return received and received.envelope.valid and received.data.value == 2 * value

    return eventually(came, 30.0, f"{2 * value} from the toy")


def sources(node):
    """Return what the toy reads, as everybody sees it."""
    return list(node.directory.owner(SINK).sources)


def test_a_third_party_connects_and_disconnects_two_ports(start, hub, node):
    start(TOY)
    inp = node.input("/test/in:i", Number, source="/toy/out:o")
    node.ready()
    with writing(hub) as out:
        told = connect(node, "/other/out:o", SINK)
        assert told == {"sink": SINK, "sources": ["/test/out:o", "/other/out:o"]}
        doubled(node, out, inp, 4.0)
        assert connect(node, "/other/out:o", SINK) == told, "a second time changes nothing"
        eventually(lambda: sources(node) == told["sources"])
        assert Connection("/other/out:o", SINK, False) in connections(node)
        disconnect(node, "/other/out:o", SINK)
        eventually(lambda: not out.matched)
        eventually(lambda: sources(node) == ["/test/out:o"])


def test_connecting_waits_a_little_for_a_port_that_is_just_being_opened(start, hub, node):
    start(TOY)
    node.ready()
    with Node("writer", connect=hub, signals=False) as late:
        late.output("/other/out:o", Number)
        opening = threading.Timer(0.3, late.ready)
        opening.start()
        told = connect(node, "/other/out:o", SINK, timeout=30.0)
        opening.join()
    assert told["sources"] == ["/test/out:o", "/other/out:o"]


def test_a_connection_survives_the_restart_of_its_output(start, hub, node):
    start(TOY)
    inp = node.input("/test/in:i", Number, source="/toy/out:o")
    node.ready()
    with writing(hub) as out:
        connect(node, "/other/out:o", SINK)
        doubled(node, out, inp, 1.0)
    with writing(hub) as out:
        doubled(node, out, inp, 2.0)


def test_a_persistent_connection_survives_the_restart_of_its_input(start, hub, node):
    inp = node.input("/test/in:i", Number, source="/toy/out:o")
    node.ready()
    first = start(TOY)
    with writing(hub) as out:
        connect(node, "/other/out:o", SINK, persist=True)
        disconnect(node, "/test/out:o", SINK, persist=True)
        first.stop()
        states = ["waiting", "apart", "waiting"]  # the last is our own input's
        eventually(lambda: [c.state for c in connections(node)] == states)
        start(TOY)
        eventually(lambda: sources(node) == ["/other/out:o"])
        doubled(node, out, inp, 3.0)
        forget(node, "/other/out:o", SINK)
        forget(node, "/test/out:o", SINK)
        assert Connection("/other/out:o", SINK, False) in connections(node)


def test_a_persistent_connection_may_be_wished_before_its_ports_exist(start, hub, node):
    inp = node.input("/test/in:i", Number, source="/toy/out:o")
    node.ready()
    assert connect(node, "/other/out:o", SINK, persist=True) == {"sink": SINK, "sources": []}
    assert Connection("/other/out:o", SINK, True, "waiting") in connections(node)
    start(TOY)
    with writing(hub) as out:
        doubled(node, out, inp, 5.0)
    forget(node, "/other/out:o", SINK)


@pytest.mark.parametrize("change", [connect, disconnect])
def test_a_wish_is_kept_though_the_owner_of_its_input_has_just_gone(
    hub, writer, node, change, monkeypatch
):
    """Its name is seen for a moment yet."""

    def nobody(*_: object) -> None:
        raise RpcAbsent("nobody answers")

    node.input("/test/in:i", Number, source="/other/out:o")
    writer.output("/other/out:o", Number)
    node.ready()
    writer.ready()
    with Node("asker", connect=hub, signals=False) as asker:
        eventually(lambda: all(map(asker.directory.owner, ("/test/in:i", "/other/out:o"))))
        monkeypatch.setattr(asker, "call", nobody)
        told = change(asker, "/other/out:o", "/test/in:i", persist=True)
        assert told == {"sink": "/test/in:i", "sources": []}
        with pytest.raises(RpcAbsent):
            change(asker, "/other/out:o", "/test/in:i")
        forget(asker, "/other/out:o", "/test/in:i")


def test_what_cannot_be_connected_is_refused_with_what_exists(start, hub, node):
    start(TOY)
    node.ready()
    with writing(hub, "/other/mixed:o", Mixed):
        eventually(lambda: all(map(node.directory.owner, (SINK, "/other/mixed:o"))))
        with pytest.raises(BusError, match="unknown port /tow/in:i .did you mean /toy/in:i"):
            connect(node, "/toy/out:o", "/tow/in:i", timeout=0.5)
        with pytest.raises(BusError, match="carries Mixed/1, /toy/in:i reads Number/1"):
            connect(node, "/other/mixed:o", SINK)
        with pytest.raises(BusError, match="is an rpc port, expected an input"):
            connect(node, "/toy/out:o", "/toy/rpc:i")
        with pytest.raises(BusError, match="ends in :i"):
            connect(node, "/toy/out:o", "/toy/out:o")
        with pytest.raises(RpcError, match="does not read /toy/out:o; it reads /test/out:o"):
            disconnect(node, "/toy/out:o", SINK)


def test_a_polled_and_a_resting_input_are_rewired_too(hub, node):
    inp = node.input("/test/in:i", Number, depth=8, polled=True)
    with writing(hub) as out:
        node.ready()
        inp.rest(True)
        inp.connect("/other/out:o")
        assert not out.matched
        inp.rest(False)
        eventually(lambda: out.matched)
        out.write(Number(value=1.0))
        eventually(lambda: inp.newest())


@pytest.mark.parametrize("polled", [False, True])
def test_what_passes_while_an_input_is_disconnected_is_not_lost(hub, node, polled):
    inp = node.input("/test/in:i", Number, "/other/out:o", depth=8, polled=polled)
    with writing(hub) as out:
        node.ready()
        for connected in (True, False, True):
            if connected:
                inp.connect("/other/out:o")
                eventually(lambda: out.matched and node.directory.leader("/other/out:o"))
                eventually(lambda: out.write(Number(value=1.0)) or inp.newest())
            else:
                inp.disconnect("/other/out:o")
                eventually(lambda: not out.matched)
                for _ in range(5):
                    out.write(Number(value=2.0))
        assert (inp.statistics.lost, inp.statistics.repeated) == (0, 0)


def test_wishes_outlive_the_hub(tmp_path):
    path = tmp_path / "state" / "lab.json"
    Wishes(path).answer(["set", "/a:i", "/b:o", True])
    again = Wishes(path)
    assert again.answer(["of", ["/a:i", "/c:i"]]) == {"/a:i": {"/b:o": True}}
    again.answer(["forget", "/a:i", "/b:o"])
    assert json.loads(path.read_text()) == {}


def test_a_spoilt_file_of_wishes_is_left_alone(tmp_path):
    path = tmp_path / "lab.json"
    path.write_text("{not json")
    Wishes(path).answer(["set", "/a:i", "/b:o", True])
    assert path.read_text() == "{not json"


@pytest.mark.parametrize("request_", [None, [], ["set", "/a:i", "/b:o", "yes"], ["of", 3], {}])
def test_bad_requests_to_the_hub_are_refused(request_):
    with pytest.raises(ValueError, match="expected all, of, set or forget"):
        Wishes().answer(request_)


def test_names_without_end_are_not_kept():
    with pytest.raises(ValueError, match="more than 255 characters"):
        Wishes().answer(["set", f"/{'a' * 300}:i", "/b:o", True])


def test_two_namespaces_have_wishes_of_their_own():
    with running_hub() as endpoint:
        with (
            Node("a", connect=endpoint, namespace="one", signals=False) as one,
            Node("a", connect=endpoint, namespace="two", signals=False) as two,
        ):
            connect(one, "/x:o", "/y:i", persist=True)
            assert connections(one) == [Connection("/x:o", "/y:i", True, "waiting")]
            assert connections(two) == []


def test_a_service_that_feeds_itself_still_answers_and_ends(start, node):
    toy = start(TOY)
    out = node.output("/test/out:o", Number)
    node.ready()
    connect(node, "/toy/out:o", SINK)
    eventually(lambda: out.matched)
    out.write(Number(value=0.0))
    disconnect(node, "/toy/out:o", SINK)
    connect(node, "/toy/out:o", SINK)
    assert toy.stop() == 0
