"""Real time with bounded catch-up."""

from robot_sim.pace import RealTime, SlipWatch

TICK = 1_000_000


def test_in_time_one_tick_is_due_per_millisecond():
    pace = RealTime(TICK)
    pace.start(0)
    assert [pace.due(now * TICK) for now in range(5)] == [0, 1, 1, 1, 1]
    assert pace.slipped == 0


def test_a_short_stall_is_caught_up_at_once():
    pace = RealTime(TICK)
    pace.start(0)
    assert pace.due(7 * TICK) == 7
    assert pace.due(7 * TICK) == 0
    assert pace.slipped == 0


def test_a_long_stall_is_caught_up_in_part_and_the_rest_is_counted():
    pace = RealTime(TICK, burst=10)
    pace.start(0)
    assert pace.due(100 * TICK) == 10
    assert pace.slipped == 90
    assert pace.due(101 * TICK) == 1


def test_the_time_to_the_next_tick_is_never_negative():
    pace = RealTime(TICK)
    pace.start(0)
    assert pace.remaining(0) == 1e-3
    assert pace.remaining(5 * TICK) == 0.0


def test_a_pause_is_not_caught_up():
    pace = RealTime(TICK)
    pace.start(0)
    pace.start(1000 * TICK)
    assert pace.due(1000 * TICK) == 0
    assert pace.due(1001 * TICK) == 1


def test_another_speed_begins_now():
    pace = RealTime(TICK)
    pace.start(0)
    pace.change(10 * TICK, 1000 * TICK)
    assert pace.due(1009 * TICK) == 0
    assert pace.due(1010 * TICK) == 1
    pace.change(10 * TICK, 1011 * TICK)  # the same: the next tick stays where it is
    assert pace.due(1020 * TICK) == 1
    assert pace.slipped == 0


def test_lost_real_time_is_noticed_once_per_period_and_a_little_is_not():
    watch = SlipWatch(period=1000, share=0.1)
    assert watch.lost(5000, ticks=10, slipped=90) == 0.0  # what the start cost
    assert watch.lost(5500, ticks=20, slipped=200) == 0.0
    assert watch.lost(6000, ticks=90, slipped=110) == 0.2
    assert watch.lost(6001, ticks=90, slipped=500) == 0.0
    assert watch.lost(7000, ticks=1090, slipped=120) == 0.0
