"""Names are taken over on purpose, and agreed on where no hub answers."""

import threading
import time

import pytest

from bus import BusError, NameTaken, Node, claims
from bus.introspection import wait_for_service
from bus.links import alone_since
from bus.rpc import Request
from bus.testing import collect, eventually, start_hub
from bus.tokens import Token
from tests.bus.messages import Number

TOY = "tests.bus.toys"


def open_node(name, hub, **more):
    return Node(name, connect=hub, signals=False, **more)


def test_a_take_over_raises_the_epoch_and_the_former_owner_ends(start, hub, node):
    old = start(TOY)
    inp = node.input("/test/in:i", Number, source="/toy/out:o", depth=64)
    node.ready()
    collect(node, inp, 3)
    new = start(TOY, "--take-over")
    old.expected = None
    assert old.popen.wait(60) == 1
    assert "lost /toy/" in old.output and f"pid {new.pid}" in old.output
    assert node.directory.owner("/toy/out:o").epoch == 1
    inp.newest()
    assert all(m.envelope.epoch == 1 for m in collect(node, inp, 5)), "the new one is heard"


def test_each_take_over_is_one_epoch_higher(start, hub, node):
    node.ready()
    owner = start(TOY)
    for epoch in (1, 2):
        former, owner = owner, start(TOY, "--take-over")
        former.expected = None
        assert former.popen.wait(60) == 1
        assert node.directory.owner("/toy/out:o").epoch == epoch


def test_a_take_over_of_free_names_is_an_ordinary_claim(hub):
    with open_node("alone", hub, take_over=True) as node:
        out = node.output("/alone/x:o", Number)
        node.ready()
        assert out.epoch == 0


@pytest.fixture
def linked_without_hub():
    """Three nodes that have met through a hub, which then died."""
    endpoint, process = start_hub()
    nodes = [open_node(f"peer{k}", endpoint) for k in range(3)]
    try:
        for node in nodes:
            node.ready()
        process.kill()
        eventually(lambda: not any(list(n.session.info.routers_zid()) for n in nodes))
        yield nodes
    finally:
        for node in nodes:
            node.close()
        process.clean_up()


def test_without_a_hub_a_new_name_is_claimed_among_peers(linked_without_hub):
    writer, reader, _ = linked_without_hub
    out = writer.output("/late/x:o", Number)
    inp = reader.input("/late/in:i", Number, source="/late/x:o")
    eventually(lambda: out.matched)
    out.write(Number(value=1.0))
    assert eventually(inp.newest).data.value == 1.0


def test_a_rival_that_stands_between_the_look_and_the_claim_is_not_overlooked(linked_without_hub):
    first, second, _ = linked_without_hub
    rival = Token("/late/x:o", "output", "Number/1", 0.0, second.owner, 0, b"\xff" * 16, ())
    with second.session.liveliness().declare_token(rival.key()):
        eventually(lambda: first.directory.owner("/late/x:o") == rival)
        looks, owner_of = iter([None]), first.ports._owner_of
        first.ports._owner_of = lambda name: next(looks, owner_of(name))
        with pytest.raises(NameTaken, match="lost /late/x:o: .* is taken by peer1"):
            first.output("/late/x:o", Number)
    first.wait(0.0)


def test_who_has_been_without_a_hub_for_a_while_does_not_wait_for_it_again(
    linked_without_hub, monkeypatch
):
    writer, *_ = linked_without_hub
    eventually(lambda: time.monotonic() > alone_since(writer.session) + claims.ALONE)
    asked = []
    ask = lambda *arguments, **more: asked.append(Request(*arguments, **more)) or asked[-1]  # noqa: E731
    monkeypatch.setattr(claims, "Request", ask)
    assert writer.output("/late/x:o", Number).standing
    assert len(asked) == 1


def test_who_is_linked_with_a_hub_is_not_alone(hub, node):
    node.ready()
    now = time.monotonic()
    assert alone_since(node.session) >= now


def test_without_a_hub_who_has_a_name_keeps_it(linked_without_hub):
    first, second, third = linked_without_hub
    out = first.output("/late/x:o", Number)
    with pytest.raises(NameTaken, match="/late/x:o is taken by peer0"):
        second.output("/late/x:o", Number)
    assert out.standing and second.ports.get("/late/x:o") is None
    second.wait(0.0)
    assert third.directory.owner("/late/x:o").owner.service == "peer0"


def test_without_a_hub_exactly_one_of_simultaneous_claimants_wins(linked_without_hub):
    outcomes = []
    barrier = threading.Barrier(3)

    def claim(node):
        barrier.wait()
        try:
            outcomes.append(node.output("/contested/x:o", Number))
        except BusError as error:
            outcomes.append(error)

    threads = [threading.Thread(target=claim, args=(node,)) for node in linked_without_hub]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join()
    refused = [error for error in outcomes if isinstance(error, NameTaken)]
    assert len(refused) == 2, outcomes
    (winner,) = (out for out in outcomes if not isinstance(out, Exception))
    assert winner.standing
    leaders = [node.directory.leader("/contested/x:o") for node in linked_without_hub]
    assert leaders == 3 * [winner.source]


def test_terminate_ends_a_service_as_a_signal_does(start, node):
    toy = start(TOY)
    wait_for_service(node, "toy")
    node.call("/toy/rpc:i", "terminate")
    assert toy.popen.wait(30) == 0
