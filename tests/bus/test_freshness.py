"""When data are too old, decided without a bus."""

import pytest

from bus.clock import SessionClock
from bus.envelope import Envelope, Received
from bus.freshness import Freshness, Lateness

SECOND = 1_000_000_000  # ns
OFFSET = 1_700_000_000 * SECOND  # between the writer's wall clock and our monotonic one


@pytest.fixture
def now(monkeypatch):
    """Our monotonic clock, moved by hand: a list of one number [s]."""
    time = [1000.0]
    monkeypatch.setattr("time.monotonic_ns", lambda: round(time[0] * SECOND))
    return time


def message(sent, arrival, source=b"s" * 16):
    """Return a message sent and received at times of our clock [s]."""
    stamp = round(sent * SECOND) + OFFSET
    envelope = Envelope("X/1", source, 0, 1, stamp, 0, stamp, stamp, True, "", "")
    return Received(None, envelope, round(arrival * SECOND))


def stream(now, rate=100.0, lockstep=False):
    clock = SessionClock(lockstep)
    return Freshness(["/w/x:o"], rate, clock, lambda name: True), clock


@pytest.mark.parametrize(
    ("rate", "limit"), [(1000.0, 0.02), (500.0, 0.02), (100.0, 0.1), (25.0, 0.4)]
)
def test_the_limit_is_ten_periods_but_not_below_20_ms(now, rate, limit):
    freshness, _ = stream(now, rate)
    assert not freshness.fresh
    freshness.arrived(message(now[0], now[0]))
    now[0] += 0.99 * limit
    assert freshness.fresh
    now[0] += 0.02 * limit
    assert not freshness.fresh
    assert freshness.reason == f"no data on /w/x:o for {1010 * limit:.0f} ms"


def test_events_do_not_age(now):
    freshness, _ = stream(now, rate=0.0)
    freshness.arrived(message(now[0], now[0]))
    now[0] += 1000.0
    assert freshness.fresh


def test_in_lockstep_only_a_silent_clock_makes_data_stale(now):
    freshness, clock = stream(now, lockstep=True)
    clock._seen_at = round(now[0] * SECOND)
    freshness.arrived(message(now[0], now[0]))
    now[0] += 0.4
    assert freshness.fresh
    now[0] += 0.4
    assert not freshness.fresh


def test_a_pause_is_not_counted(now):
    freshness, clock = stream(now)
    freshness.arrived(message(now[0], now[0]))
    clock._paused_at = clock._seen_at = round((now[0] + 0.03) * SECOND)
    for _ in range(100):
        now[0] += 0.1
        clock._seen_at = round(now[0] * SECOND)
        assert freshness.fresh
    clock._paused_at, clock.resumed_at = 0, round(now[0] * SECOND)
    now[0] += 0.09
    assert freshness.fresh
    now[0] += 0.02
    assert not freshness.fresh


def test_a_pause_that_follows_another_at_once_is_not_counted_either(now):
    freshness, clock = stream(now)
    freshness.arrived(message(now[0], now[0]))
    clock.resumed_at = round((now[0] + 1.0) * SECOND)
    clock._paused_at = clock._seen_at = round((now[0] + 1.01) * SECOND)
    now[0] += 60.0
    clock._seen_at = round(now[0] * SECOND)
    assert freshness.fresh


def test_a_stream_that_was_stale_before_the_pause_stays_stale(now):
    freshness, clock = stream(now)
    freshness.arrived(message(now[0], now[0]))
    now[0] += 0.2
    clock._paused_at = clock._seen_at = round(now[0] * SECOND)
    assert not freshness.fresh


def test_old_news_is_not_fresh_although_it_has_just_come(now):
    freshness, _ = stream(now, rate=1000.0)
    for _ in range(10):
        now[0] += 0.001
        freshness.arrived(message(now[0] - 0.0005, now[0]))
    assert freshness.fresh
    now[0] += 2.0  # the reader was stopped; now it reads what has waited for it
    freshness.arrived(message(now[0] - 1.9, now[0]))
    assert not freshness.fresh
    assert freshness.reason == "data on /w/x:o come 1900 ms late"
    now[0] += 0.5  # and then none at all
    assert freshness.reason == "no data on /w/x:o for 2500 ms"
    freshness.arrived(message(now[0] - 0.001, now[0]))
    assert freshness.fresh and freshness.reason == ""


def test_what_waited_for_a_stopped_reader_is_not_read(now):
    freshness, _ = stream(now, rate=1000.0)
    assert freshness.arrived(message(now[0] - 0.0005, now[0]))
    now[0] += 30.0
    for k in range(5):
        assert not freshness.arrived(message(now[0] - 29.0 + 0.001 * k, now[0]))
    assert not freshness.fresh and "late" in freshness.reason
    assert freshness.arrived(message(now[0] - 0.001, now[0]))
    assert freshness.fresh


def test_in_lockstep_nothing_is_too_late(now):
    freshness, _ = stream(now, lockstep=True)
    freshness.arrived(message(now[0], now[0]))
    now[0] += 30.0
    assert freshness.arrived(message(now[0] - 29.0, now[0]))


@pytest.mark.parametrize("jump", [-3600, 3600])
def test_a_jump_of_the_writers_clock_makes_nothing_late(jump):
    lateness, source = Lateness(), b"s" * 16
    for k in range(200):
        at = k * SECOND // 100
        lateness.arrived(source, at + (jump * SECOND if k >= 100 else 0), at)
        assert lateness.seconds == 0.0
    lateness.arrived(b"t" * 16, 0, 7 * SECOND)
    assert lateness.seconds == 0.0


def test_of_two_writers_that_take_turns_each_has_its_own_usual_delay():
    lateness = Lateness()
    for k in range(100):
        lateness.arrived(b"a" * 16, k * SECOND // 100, k * SECOND // 100)
        lateness.arrived(b"b" * 16, k * SECOND // 100 - 7 * SECOND, k * SECOND // 100)
        assert lateness.seconds == 0.0
    for source, clock in ((b"a" * 16, 0), (b"b" * 16, -7 * SECOND)):
        lateness.arrived(source, SECOND + clock, 4 * SECOND)
        assert lateness.seconds == 3.0


def test_the_first_message_of_a_new_writer_here_may_have_waited_for_us(monkeypatch):
    monkeypatch.setattr("time.monotonic_ns", lambda: 50 * SECOND)
    monkeypatch.setattr("time.time_ns", lambda: 50 * SECOND + OFFSET)
    here, elsewhere = Lateness(lambda source: True), Lateness()
    for lateness, expected in ((here, 3.0), (elsewhere, 0.0)):
        lateness.arrived(b"s" * 16, 47 * SECOND + OFFSET, 50 * SECOND)
        assert lateness.seconds == expected


def test_writers_that_have_gone_are_forgotten():
    lateness = Lateness()
    for k in range(100):
        lateness.arrived(k.to_bytes(16), 0, k)
    assert len(lateness._usual) == 16
