"""Questions and answers."""

import signal
import threading
import time
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
import pytest
import zenoh

import bus.rpc
from bus import Node, Pending, RpcAbsent, RpcError, RpcTimeout, call
from bus.introspection import wait_for_port
from bus.packing import pack
from bus.testing import eventually
from tests.bus.messages import Number

PORT = "/server/rpc:i"


@pytest.fixture
def server(hub):
    """A node whose main loop runs in a thread."""
    with Node("server", connect=hub, signals=False) as node:
        node.ready()
        loop = threading.Thread(
            target=lambda: [node.wait(0.02) for _ in iter(lambda: node.running, False)]
        )
        loop.start()
        yield node
        node.stop()
        loop.join()


def test_a_handler_gets_its_arguments_and_its_value_comes_back(server, node):
    server.verb("add", lambda a, b=1: {"sum": a + b, "list": [1, (2, None)]})
    assert node.call(PORT, "add", {"a": 2}) == {"sum": 3, "list": [1, [2, None]]}
    assert call(node.session, PORT, "add", {"a": 2, "b": 5})["sum"] == 7


def test_numpy_values_travel_as_plain_ones(server, node):
    server.verb("numbers", lambda: {"a": np.arange(3.0), "b": np.float64(2.5), "c": np.bool_(True)})
    assert node.call(PORT, "numbers") == {"a": [0.0, 1.0, 2.0], "b": 2.5, "c": True}


@pytest.mark.parametrize(
    ("error", "text"),
    [
        (ValueError("bad seconds: 3"), "bad seconds: 3"),
        (KeyError("no such link"), "no such link"),
        (RuntimeError("the robot moves"), "the robot moves"),
        (ZeroDivisionError(), "ZeroDivisionError"),
    ],
)
def test_a_handlers_exception_reaches_the_caller(server, node, error, text):
    def fail():
        raise error

    server.verb("fail", fail)
    with pytest.raises(RpcError, match=f"^{text}$"):
        node.call(PORT, "fail")
    assert node.call(PORT, "status")["service"] == "server"


@pytest.mark.parametrize(
    ("verb", "arguments", "text"),
    [
        ("stauts", {}, r"unknown verb 'stauts' \(did you mean status\?\); there are: help, status"),
        ("param", {}, "param: missing a required argument: 'action'; expected"),
        ("status", {"x": 1}, "status: got an unexpected keyword argument 'x'"),
    ],
)
def test_a_wrong_question_is_answered_with_what_exists(server, node, verb, arguments, text):
    with pytest.raises(RpcError, match=text):
        node.call(PORT, verb, arguments)


def test_a_value_that_cannot_travel_is_an_error_of_the_handler(server, node):
    server.verb("odd", lambda: object())
    server.verb("nan", lambda: float("nan"))
    for verb in ("odd", "nan"):
        with pytest.raises(RpcError, match="answer: expected"):
            node.call(PORT, verb)


def test_a_pending_answer_comes_later(server, node):
    waiting = []
    server.verb("wait", lambda: waiting.append(Pending()) or waiting[-1])
    server.verb("release", lambda: waiting.pop().reply("done"))
    server.verb("refuse", lambda: waiting.pop().fail("not now"))
    for release, expected in (("release", "done"), ("refuse", RpcError("not now"))):
        answers = []
        thread = threading.Thread(target=lambda got=answers: got.append(attempt(node, "wait")))
        thread.start()
        eventually(lambda: waiting)
        node.call(PORT, release)
        thread.join()
        assert repr(answers) == repr([expected])


def attempt(node, verb):
    try:
        return node.call(PORT, verb)
    except RpcError as error:
        return error


def test_an_answer_may_be_given_before_the_handler_returns(server, node):
    def early():
        pending = Pending()
        pending.reply(5)
        with pytest.raises(RuntimeError, match="already answered"):
            pending.reply(6)
        return pending

    server.verb("early", early)
    assert node.call(PORT, "early") == 5


def test_an_absent_port_is_told_from_a_hung_one(server, node, hub):
    with pytest.raises(RpcAbsent, match="nobody answers on /nobody/rpc:i"):
        node.call("/nobody/rpc:i", "status")
    with Node("hung", connect=hub, signals=False) as hung:
        hung.ready()
        with pytest.raises(RpcTimeout, match=r"/hung/rpc:i status: no answer within 0.2 s"):
            node.call("/hung/rpc:i", "status", timeout=0.2)


def test_a_port_of_which_only_the_hub_knows_yet_is_not_absent(server, node, monkeypatch):
    """On a loaded machine a young session may be linked late with the owner."""
    unreached = wait_for_port(node, PORT)._replace(name="/unreached/rpc:i")
    monkeypatch.setattr(bus.rpc, "ABSENCE", 0.0)
    monkeypatch.setattr(node.directory, "leader", lambda name: None)
    with server.session.liveliness().declare_token(unreached.key()):
        eventually(lambda: node.stands("/unreached/rpc:i"))
        with pytest.raises(RpcTimeout):
            node.call("/unreached/rpc:i", "status", timeout=0.5)
    eventually(lambda: not node.stands("/unreached/rpc:i"))
    with pytest.raises(RpcAbsent):
        node.call("/unreached/rpc:i", "status", timeout=30.0)


def test_a_server_that_does_not_own_its_name_yet_answers_nothing(server, node, hub):
    """A newcomer that loads its model must not answer, or hang, for the owner."""
    with Node("server", connect=hub, signals=False):
        for _ in range(20):
            assert node.call(PORT, "status")["service"] == "server"


def test_a_stopped_process_is_a_timeout_and_a_killed_one_is_absent(start, node):
    toy = start("tests.bus.toys", service="toy")
    assert node.call("/toy/rpc:i", "double", {"value": 4}) == 8
    toy.send(signal.SIGSTOP)
    with pytest.raises(RpcTimeout):
        node.call("/toy/rpc:i", "double", {"value": 4}, timeout=0.5)
    toy.send(signal.SIGCONT)
    toy.kill()
    with pytest.raises(RpcAbsent):
        node.call("/toy/rpc:i", "double", {"value": 4}, timeout=30.0)


def test_two_servers_on_one_port_are_told(server, node, hub):
    def answer(query: zenoh.Query) -> None:
        query.reply(query.key_expr, pack(1))

    rogue = zenoh.handlers.Callback(answer, indirect=False)
    with Node("rogue", connect=hub, signals=False) as other:
        other.session.declare_queryable("server/rpc:i", rogue)
        other.ready()
        with pytest.raises(RpcError, match="2 servers answer on /server/rpc:i"):
            eventually(lambda: node.call(PORT, "status") is None)


@pytest.mark.parametrize(
    "payload",
    [b"", b"\xc1", pack("status"), pack(["status"]), bytes(100_000)],
    ids=["empty", "garbage", "text", "short", "long"],
)
def test_a_garbled_question_is_answered_with_an_error(server, node, payload):
    node.call(PORT, "status")
    (reply,) = node.session.get("server/rpc:i", payload=payload, timeout=5.0)
    assert b"error" in reply.err.payload.to_bytes()


def test_a_request_that_is_too_long_is_refused_by_the_caller(node):
    with pytest.raises(RpcError, match="at most 65536"):
        node.call(PORT, "status", {"x": "y" * 70_000})


def test_whoever_waits_is_told_when_the_server_leaves(node, hub):
    with Node("leaving", connect=hub, signals=False) as leaving:
        leaving.verb("wait", Pending)
        leaving.ready()
        errors = []
        thread = threading.Thread(target=lambda: errors.append(_error(node)))
        thread.start()
        eventually(lambda: leaving.wait(0.05))
    thread.join()
    assert "is closing" in str(errors[0])


def _error(node):
    try:
        return node.call("/leaving/rpc:i", "wait")
    except RpcError as error:
        return error


def test_a_question_costs_little(server, node):
    node.call(PORT, "status")
    times = []
    for _ in range(50):
        began = time.monotonic()
        node.call(PORT, "status")
        times.append(time.monotonic() - began)
    assert sorted(times)[5] < 0.05  # 0.3 ms on a quiet machine


@dataclass(frozen=True)
class Move:
    """A typed request."""

    joint: str
    angles: np.ndarray = field(metadata={"shape": ("n",), "unit": "rad"})
    speed: float = 1.0


@dataclass(frozen=True)
class Moved:
    """A typed answer."""

    joint: str
    count: int


def test_requests_and_answers_are_typed_on_both_sides(server, node):
    def move(request: Move, mode: Literal["fast", "slow"] = "fast") -> Moved:
        assert request.angles.dtype == float and request.speed == 2.0
        return Moved(f"{request.joint} {mode}", len(request.angles))

    server.verb("move", move)
    request = Move("elbow", np.array([0.5, 1.0]), 2.0)
    moved = call(node, PORT, "move", {"request": request}, returns=Moved)
    assert moved == Moved("elbow fast", 2)
    for wrong, text in (
        ({"request": {"joint": 3, "angles": []}}, "move: field joint: expected str, got int 3"),
        ({"request": {"joint": "elbow"}}, "move: request: .*missing .*'angles'"),
        ({"request": {"joint": "e", "angles": [[1.0]]}}, r"field angles: expected shape \('n',\)"),
        ({"request": {"elbow": 1}}, "move: request: expected a map with some of joint, angles"),
        ({"request": request, "mode": "wild"}, "move: field mode: expected 'fast' or 'slow', got"),
    ):
        with pytest.raises(RpcError, match=text):
            node.call(PORT, "move", wrong)
    with pytest.raises(RpcError, match="/server/rpc:i move: .*expected a finite number, got dict"):
        call(node, PORT, "move", {"request": request}, returns=float)


def test_an_answer_that_is_not_what_its_handler_declares_is_an_error(server, node):
    def wrong() -> int:
        return "three"  # type: ignore[return-value]

    server.verb("wrong", wrong)
    with pytest.raises(RpcError, match="field answer: expected int, got str 'three'"):
        node.call(PORT, "wrong")


def test_every_question_gets_its_own_answer(server, node):
    server.verb("square", lambda value: value * value)
    assert [node.call(PORT, "square", {"value": k}) for k in range(100)] == [
        k * k for k in range(100)
    ]


def test_an_answer_arrives_although_its_server_leaves_at_once(hub, node):
    for k in range(10):
        with Node("brief", connect=hub, signals=False) as brief:
            brief.verb("bye", lambda brief=brief, k=k: brief.stop() or k)
            brief.ready()
            answers = []
            asking = threading.Thread(target=lambda a=answers: a.append(attempt_on(node)))
            asking.start()
            while brief.running:
                brief.wait(0.05)
        asking.join()
        assert answers == [k]


def attempt_on(node):
    return node.call("/brief/rpc:i", "bye", timeout=30.0)


def test_who_asks_a_server_that_never_answers_gets_on(server, node):
    server.verb("never", Pending)
    for _ in range(3):
        with pytest.raises(RpcTimeout, match=r"never: no answer within 0\.1 s"):
            node.call(PORT, "never", timeout=0.1)
    assert node.call(PORT, "status")["service"] == "server"


def test_a_handler_that_is_slow_holds_up_no_messages(start, node):
    """Messages are kept for the service meanwhile; it goes on with the newest ones."""
    start("tests.bus.toys", service="toy")
    out = node.output("/test/out:o", Number, rate=100.0)
    answers = node.input("/test/in:i", Number, source="/toy/out:o", depth=256)
    node.ready()
    eventually(lambda: out.matched and node.directory.leader("/toy/out:o"))
    with pytest.raises(RpcTimeout):
        node.call("/toy/rpc:i", "hang", {"seconds": 3.0}, timeout=0.1)
    worst = 0.0
    for k in range(10):
        began = time.monotonic()
        out.write(Number(value=float(k)))
        worst = max(worst, time.monotonic() - began)
    assert worst < 2.5
    eventually(lambda: (r := answers.read()) and r.envelope.valid and r.data.value == 18.0)
