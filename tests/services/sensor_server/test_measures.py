import numpy as np
import pytest

from services.sensor_server.measures import Ages, RunningTime

SECOND = 1_000_000_000  # [ns]


def test_running_time_counts_only_while_the_clock_runs():
    time = RunningTime()
    time.advance(5 * SECOND)
    assert time.advance(6 * SECOND) == 1.0
    assert time.advance(9 * SECOND, running=False) == 1.0
    assert time.advance(10 * SECOND) == 2.0


def test_running_time_does_not_run_back():
    time = RunningTime()
    time.advance(5 * SECOND)
    assert time.advance(1 * SECOND) == 0.0
    assert time.advance(2 * SECOND) == 1.0


def test_ages_are_summed_up_over_the_last_messages():
    ages = Ages(window=100)
    assert ages.summary() == {"count": 0, "window": 0}
    for age in np.arange(150.0):
        ages.add(age)
    summary = ages.summary()
    assert summary["count"] == 150 and summary["window"] == 100 and summary["max"] == 149.0
    assert summary["p50"] == pytest.approx(99.5) and summary["p99"] == pytest.approx(148.01)
