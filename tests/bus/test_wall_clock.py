"""A wall clock that jumps: ages, freshness and waits go by the monotonic one."""

import time

import pytest

from bus import Node
from bus.claims import describe
from bus.clock import SessionClock
from bus.testing import eventually
from tests.bus.messages import Number
from tests.bus.source import jump

HOUR = 3600.0  # s


def test_data_stay_fresh_when_a_wall_clock_jumps(start, node):
    for service in ("source", "sink"):
        start(f"tests.bus.{service}", service=service)

    def report(clear=False):
        return node.call("/sink/rpc:i", "report", {"clear": clear})

    eventually(lambda: report()["is_fresh"])
    for service in ("source", "sink"):
        for seconds in (HOUR, -HOUR):
            node.call(f"/{service}/rpc:i", "jump", {"seconds": seconds})
            report(clear=True)
            seen = eventually(lambda: (seen := report())["received"] > 60 and seen)
            assert seen["fresh"] > 30, seen  # this machine may be busy
            assert seen["oldest_fresh"] < 1.0, seen


@pytest.mark.parametrize("seconds", [HOUR, -HOUR], ids=["forth", "back"])
def test_a_process_whose_wall_clock_has_jumped_opens_ports_and_asks(
    hub, node, seconds, monkeypatch
):
    node.ready()
    monkeypatch.setattr(time, "time_ns", time.time_ns)  # given back at the end
    jump(seconds)
    with Node("odd", connect=hub, signals=False) as odd:
        out = odd.output("/odd/out:o", Number, rate=100.0)
        odd.ready()
        inp = node.input("/test/odd:i", Number, source="/odd/out:o", rate=100.0)
        eventually(lambda: out.matched and node.directory.leader("/odd/out:o"))
        out.write(Number(value=1.0))
        received = eventually(inp.read)
        assert inp.fresh
        assert abs(received.envelope.sent - time.time_ns()) < 60e9
        assert inp.silence < 60.0
        assert "since" in describe(node.directory.owner("/odd/out:o"))


def test_waiting_for_a_wall_time_is_bounded_when_that_is_put_off(monkeypatch):
    monkeypatch.setattr(time, "time_ns", time.time_ns)
    clock = SessionClock()
    stamp = time.time_ns() + 50_000_000
    jump(-HOUR)
    began = time.monotonic()
    assert not clock.wait_until(stamp, timeout=0.2)
    assert 0.2 <= time.monotonic() - began < 5.0
    jump(2 * HOUR)
    assert clock.wait_until(stamp, timeout=5.0)
