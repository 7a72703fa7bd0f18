"""A link that is cut, and one that is slow."""

import threading
import time

import pytest

from bus import NameTaken, Node, RpcTimeout
from bus.sockets import close_connection, endpoint_address
from bus.testing import eventually
from tests.bus.messages import Number
from tests.bus.proxy import PASSIVE, Cable

LEASE = 2.0  # s
MUCH_TOO_OLD = 1.0  # s; the limit is 0.1 s, but this machine may be busy


@pytest.fixture
def cable(hub, tmp_path_factory):
    with Cable(hub, tmp_path_factory.mktemp("cable")) as cable:
        yield cable


@pytest.fixture
def far(cable):
    """A node at the other end of the cable."""
    with Node("far", **cable.options, signals=False) as node:
        cable.plug()
        yield node


class Stream:
    """A writer of the monotonic time, and a reader that judges what comes."""

    def __init__(self, near: Node, far: Node):
        self.out = near.output("/near/out:o", Number, rate=100.0)
        self.input = far.input("/far/in:i", Number, source="/near/out:o", depth=64, rate=100.0)
        near.ready()
        far.ready()
        eventually(lambda: self.out.matched and far.directory.leader("/near/out:o"))
        self._near, self._far = near, far

    def ages(self, seconds: float) -> list[tuple[float, bool]]:
        """Let it flow; return the age of each message, and whether it was taken for fresh."""
        seen = []
        end = time.monotonic() + seconds
        while time.monotonic() < end:
            self.out.write(Number(value=time.monotonic()))
            self._near.wait(0.01)
            while (received := self.input.read()) is not None:
                seen.append((time.monotonic() - received.data.value, self.input.fresh))
        return seen


@pytest.fixture
def stream(node, far):
    return Stream(node, far)


def fresh_again(stream):
    seen = stream.ages(0.05)
    return seen and seen[-1][1]


def test_a_link_that_is_cut_is_noticed_and_what_comes_after_is_fresh(stream, cable, node, far):
    eventually(lambda: fresh_again(stream))
    cable.cut()
    began = time.monotonic()
    eventually(lambda: not stream.input.fresh)
    assert stream.input.reason.startswith("no data on /near/out:o for ")
    eventually(lambda: far.directory.owner("/near/out:o") is None)
    eventually(lambda: node.directory.owner("/far/in:i") is None)
    assert LEASE / 2 < time.monotonic() - began < 10 * LEASE
    before = stream.input.statistics.lost
    for _ in range(50):  # into the void
        stream.out.write(Number(value=time.monotonic()))
    cable.heal()
    seen = []
    eventually(lambda: seen.extend(stream.ages(0.05)) or (seen and seen[-1][1]))
    assert all(age < MUCH_TOO_OLD for age, fresh in seen if fresh)
    assert stream.input.statistics.lost - before >= 50
    assert far.directory.owner("/near/out:o") and node.directory.owner("/far/in:i")


def test_a_short_cut_loses_nothing_and_what_comes_late_is_not_fresh(stream, cable):
    eventually(lambda: fresh_again(stream))
    before = stream.input.statistics.lost
    cable.cut()
    assert len(stream.ages(0.5)) < 10  # what was on its way
    cable.heal()
    seen = stream.ages(0.3)
    late = [fresh for age, fresh in seen if age > 0.3]
    assert late and not any(late)
    eventually(lambda: fresh_again(stream))
    statistics = stream.input.statistics
    assert statistics.lost - before == 0


def test_data_that_come_late_say_so_and_requests_are_answered_all_the_same(
    stream, cable, node, far
):
    eventually(lambda: fresh_again(stream))
    cable.delay = 0.3  # s
    eventually(lambda: (seen := stream.ages(0.1)) and seen[-1][0] >= 0.3)
    assert not stream.input.fresh
    eventually(lambda: stream.ages(0.1) and "ms late" in stream.input.reason)
    far.verb("double", lambda value: 2 * value)
    serving = threading.Thread(
        target=lambda: [far.wait(0.02) for _ in iter(lambda: far.running, False)]
    )
    serving.start()
    began = time.monotonic()
    assert node.call("/far/rpc:i", "double", {"value": 4}, timeout=30.0) == 8
    assert time.monotonic() - began >= 0.6
    with pytest.raises(RpcTimeout):
        node.call("/far/rpc:i", "double", {"value": 4}, timeout=0.3)
    far.stop()
    serving.join()
    cable.delay = 0.0
    eventually(lambda: fresh_again(stream))


def test_of_two_owners_that_a_cut_has_parted_the_later_one_stays(cable, node, far, hub):
    first = far.output("/contested/x:o", Number)
    far.ready()
    node.ready()
    eventually(lambda: node.directory.owner("/contested/x:o"))
    cable.cut()
    eventually(lambda: node.directory.owner("/contested/x:o") is None)
    second = node.output("/contested/x:o", Number)
    assert first.standing and second.standing
    cable.heal()
    with pytest.raises(NameTaken, match="lost /contested/x:o"):
        eventually(lambda: far.wait(0.05) and False)
    node.wait(0.05)
    assert second.standing and not first.standing
    eventually(lambda: node.directory.leader("/contested/x:o") == second.source)


def test_peers_that_only_lost_each_other_meet_again(hub, node):
    """As after a stop for about the lease, when the hub still has both."""
    with Node("other", connect=hub, signals=False) as other:
        out = other.output("/other/out:o", Number)
        inp = node.input("/test/in:i", Number, source="/other/out:o")
        other.ready()
        node.ready()
        eventually(lambda: out.matched and node.directory.leader("/other/out:o"))
        peer = str(other.session.zid())
        links = [link for link in node.session.info.links() if str(link.zid) == peer]
        for link in links:
            assert close_connection(endpoint_address(link.src), endpoint_address(link.dst))
        eventually(lambda: not out.matched)
        eventually(lambda: out.matched and node.directory.leader("/other/out:o"))
        out.write(Number(value=1.0))
        assert eventually(inp.read).data.value == 1.0


def test_a_peer_that_could_not_be_reached_when_a_newcomer_came_is_met_all_the_same(
    hub, tmp_path_factory
):
    """As one that is stopped while it is dialled: gossip tells of it only once."""
    directory = tmp_path_factory.mktemp("peer")
    passive, door, moved = (directory / name for name in ("zenoh.json5", "door", "moved"))
    passive.write_text(PASSIVE)
    listen = f"unixsock-stream/{door}"
    with Node("early", hub, listen, zenoh_config=passive, signals=False) as early:
        early.ready()
        door.rename(moved)
        with Node("late", connect=hub, signals=False) as late:
            late.ready()
            assert not linked(late, early)
            moved.rename(door)
            eventually(lambda: linked(late, early))
            eventually(lambda: late.directory.owner("/early/rpc:i"))


def linked(node: Node, other: Node) -> bool:
    return str(other.session.zid()) in map(str, node.session.info.peers_zid())
