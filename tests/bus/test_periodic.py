"""The periodic loop, on a clock made by hand."""

import pytest

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
