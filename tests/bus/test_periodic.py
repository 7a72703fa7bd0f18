"""The periodic loop, on a clock made by hand."""

import threading

import pytest

from bus import Node
from bus.periodic import Periodic


class Time:
    """Time that passes only when somebody waits or works."""

    def __init__(self):
        self.now = 100.0

    def sleep(self, seconds):
        self.now += seconds


@pytest.fixture
def hand():
    return Time()


def loop(hand, period=0.01, **more):
    return Periodic(period, wait=hand.sleep, now=lambda: hand.now, **more)


def test_the_schedule_is_absolute(hand):
    periodic = loop(hand)
    for _ in range(100):
        hand.now += 0.003  # work
        periodic.next()
    assert hand.now == pytest.approx(101.0)
    assert periodic.statistics.cycles == 100
    assert periodic.statistics.period == pytest.approx(0.01)
    assert periodic.statistics.overruns == 0


def test_a_late_cycle_is_caught_up(hand):
    periodic = loop(hand)
    hand.now += 0.035
    for _ in range(5):
        periodic.next()
    assert hand.now == pytest.approx(100.05)
    assert periodic.statistics.overruns == 3
    assert periodic.statistics.slipped == 0.0
    assert periodic.statistics.worst == pytest.approx(0.025)


def test_what_cannot_be_caught_up_is_given_up_and_counted(hand):
    periodic = loop(hand, catch_up=10)
    hand.now += 1.01
    periodic.next()
    assert periodic.statistics.slipped == pytest.approx(0.9)
    for _ in range(10):
        periodic.next()
    assert hand.now == pytest.approx(101.01)


def test_a_period_must_be_positive():
    with pytest.raises(ValueError, match="period must be positive, got 0.0 s"):
        Periodic(0.0)


def test_period_jitter_and_overruns_are_reported(hand):
    periodic = loop(hand)
    for work in (0.0, 0.003, 0.016, 0.0):
        hand.now += work
        periodic.next()
    report = periodic.statistics.report()
    assert report == {
        "cycles": 4,
        "period_s": pytest.approx(0.01),
        "jitter_s": pytest.approx(0.003),  # 6 ms late once in four cycles
        "worst_s": pytest.approx(0.006),
        "overruns": 1,
        "slipped_s": 0.0,
    }


def test_the_period_may_be_changed_at_run_time(hand):
    periodic = loop(hand)
    periodic.next()
    periodic.period = 0.5
    periodic.next()
    assert hand.now == pytest.approx(100.51)


def test_a_time_that_jumps_back_begins_a_new_schedule(hand):
    periodic = loop(hand)
    periodic.next()
    hand.now = 0.0
    periodic.next()
    assert hand.now == pytest.approx(0.01)
    assert periodic.statistics.period == pytest.approx(0.01)


def test_a_loop_that_is_to_end_does_not_wait_for_its_deadline(hand):
    running = [True]
    periodic = loop(hand, period=100.0, running=lambda: running[0])
    assert periodic.next()
    running[0] = False
    assert not periodic.next()
    assert hand.now == pytest.approx(200.0)


def test_a_services_status_tells_how_its_loop_keeps_time(node):
    periodic = Periodic.of(node, 0.002)
    node.ready()
    for _ in range(5):
        assert periodic.next()
    with Node("asker", connect=node.endpoint, signals=False) as asker:
        thread = threading.Thread(target=lambda: [periodic.next() for _ in range(500)])
        thread.start()
        loop = asker.call("/test/rpc:i", "status")["loop"]
        node.stop()
        thread.join()
    assert loop["cycles"] >= 5 and loop["period_s"] >= 0.0019
    assert not periodic.next()
