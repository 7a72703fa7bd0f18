"""Names are owned."""

import os
import re
import signal
import threading

import pytest

from bus import NameTaken, Node
from bus.claims import Arbiter
from bus.envelope import new_source
from bus.introspection import wait_for_service
from bus.lost import Look
from bus.session import open_session
from bus.testing import Process, eventually, free_port
from bus.tokens import Owner, Token
from tests.bus.messages import Number

TOY = "tests.bus.toys"


def test_a_second_owner_is_told_who_has_the_name(start, hub):
    toy = start(TOY, service="toy")
    with Node("other", connect=hub, signals=False) as node:
        node.output("/toy/out:o", Number)
        match = rf"/toy/out:o is taken by toy \(host .*, pid {toy.pid}\), since \d\d:\d\d:\d\d"
        with pytest.raises(NameTaken, match=match):
            node.ready()
    assert toy.popen.poll() is None


def test_a_second_process_of_a_service_exits_with_one_line(start, hub):
    start(TOY, service="toy")
    second = Process(TOY, "--connect", hub)
    try:
        assert second.popen.wait(60) == 1
        pattern = (
            r"toy: the names /toy/rpc:i, /toy/log:o, /toy/in:i and 2 more are taken by toy .*\n"
        )
        assert re.fullmatch(pattern, second.output)
    finally:
        second.clean_up()


def test_the_names_of_a_killed_process_vanish_by_themselves(start, node):
    toy = start(TOY, service="toy")
    eventually(lambda: node.directory.owner("/toy/out:o"))
    toy.kill()
    eventually(lambda: node.directory.owner("/toy/out:o") is None)
    eventually(lambda: "toy" not in [owner.service for owner in node.directory.services()])
    start(TOY, service="toy")


def test_the_names_of_a_stopped_process_vanish_and_it_resigns_when_it_comes_back(start, node):
    old = start(TOY, service="toy")
    wait_for_service(node, "toy")
    old.send(signal.SIGSTOP)
    eventually(lambda: node.directory.owner("/toy/out:o") is None)
    new = start(TOY, service="toy")
    old.send(signal.SIGCONT)
    old.expected = None
    assert old.popen.wait(60) == 1
    assert "lost /toy/" in old.output and f"pid {new.pid}" in old.output
    assert new.popen.poll() is None
    eventually(lambda: (owner := node.directory.owner("/toy/out:o")) and owner.owner.pid == new.pid)


@pytest.mark.parametrize("race", range(5))
def test_of_simultaneous_claimants_exactly_one_wins(hub, race):
    nodes = [Node(f"claimant{k}", connect=hub, signals=False) for k in range(4)]
    outcomes = []
    barrier = threading.Barrier(len(nodes))

    def claim(node):
        node.output("/contested/x:o", Number)
        barrier.wait()
        try:
            node.ready()
            outcomes.append("won")
        except NameTaken:
            outcomes.append("taken")

    threads = [threading.Thread(target=claim, args=(node,)) for node in nodes]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    for node in nodes:
        node.close()
    assert sorted(outcomes) == ["taken", "taken", "taken", "won"]


@pytest.mark.parametrize(
    ("epoch", "source"), [(0, b"\xff"), (1, b"\0")], ids=["later source", "higher epoch"]
)
def test_of_two_that_stand_the_lower_one_resigns(node, hub, epoch, source):
    out = node.output("/a/x:o", Number)
    node.ready()
    stranger = open_session("peer", [hub], ["tcp/127.0.0.1:0"])
    owner = Owner("stranger", "host", 1, str(stranger.zid()))
    low = Token("/a/x:o", "output", "Number/1", 0.0, owner, 0, bytes(16), ())
    high = low._replace(epoch=epoch, source=source * 16)
    with stranger:
        tokens = [stranger.liveliness().declare_token(low.key())]
        eventually(lambda: len(node.directory._ports.get("/a/x:o", ())) == 2)
        node.wait(0.0)
        out.write(Number(value=1.0))
        tokens.append(stranger.liveliness().declare_token(high.key()))
        with pytest.raises(NameTaken, match="lost /a/x:o: .*taken by stranger"):
            eventually(lambda: node.wait(0.05) and False)
        assert not out.standing


def test_a_later_claim_in_a_lower_epoch_does_not_win(hub):
    """As after a cut in which somebody claimed anew what was taken over before it."""
    with Node("first", connect=hub, signals=False) as first:
        first.output("/a/x:o", Number)
        first.ready()
        with (
            Node("second", connect=hub, take_over=True, signals=False) as second,
            open_session("peer", [hub], ["tcp/127.0.0.1:0"]) as stranger,
        ):
            out = second.output("/a/x:o", Number)
            second.ready()
            owner = Owner("stranger", "host", 1, str(stranger.zid()))
            later = Token("/a/x:o", "output", "Number/1", 0.0, owner, 0, b"\xff" * 16, ())
            tokens = [stranger.liveliness().declare_token(later.key())]
            eventually(lambda: later in second.directory._ports.get("/a/x:o", {}).values())
            second.wait(0.0)
            out.write(Number(value=1.0))
            assert out.standing and second.directory.leader("/a/x:o") == out.source
            del tokens


def token(name, source=None, epoch=0):
    return Token(
        name, "output", "X/1", 0.0, Owner("s", "h", 1, "z"), epoch, source or new_source(), ()
    )


@pytest.fixture
def arbiter():
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    with open_session("router", listen=[endpoint]) as session:
        arbiter = Arbiter(session)
        yield arbiter
        arbiter.close()


def test_the_hub_grants_all_names_or_none(arbiter):
    first, second = token("/a:o"), token("/b:o")
    assert arbiter.decide("", [first]) == []
    assert arbiter.decide("", [second, token("/a:o")]) == [(first.key(), True)]
    assert arbiter.decide("", [token("/b:o")]) == []


def test_asking_again_for_a_granted_name_is_no_conflict(arbiter):
    first = token("/a:o")
    assert arbiter.decide("", [first]) == arbiter.decide("", [first]) == []


def test_namespaces_do_not_share_names(arbiter):
    assert arbiter.decide("one/", [token("/a:o")]) == []
    assert arbiter.decide("two/", [token("/a:o")]) == []


def test_nodes_of_two_namespaces_share_a_hub_but_no_names(hub):
    with (
        Node("same", connect=hub, namespace="one", signals=False) as one,
        Node("same", connect=hub, namespace="two", signals=False) as two,
    ):
        one.ready()
        two.ready()
        for node in (one, two):  # the hub tells each whose names are in its namespace
            eventually(lambda node=node: Look(node.session).owners == {str(node.session.zid())})
        assert [owner.pid for owner in one.directory.services()] == [os.getpid()]
