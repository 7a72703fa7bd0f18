import numpy as np
import pytest

from dashboard.history import History
from dashboard.rhythm import Rhythm


def test_history_keeps_the_newest_samples_in_order():
    history = History(length=3, width=2)
    for time in range(5):
        history.add(float(time), np.array([time, -time]))
    ages, values = history.column(1)
    assert ages == pytest.approx([-2.0, -1.0, 0.0])
    assert values == pytest.approx([-2.0, -3.0, -4.0])


def test_missing_sample_stays_missing():
    history = History(length=3, width=1)
    history.add(0.0, np.array([1.0]))
    history.add(1.0, np.array([np.nan]))
    assert np.isnan(history.column(0)[1]).tolist() == [False, True]


def test_time_that_ran_back_clears_the_history():
    history = History(length=3, width=1)
    history.add(5.0, np.array([1.0]))
    history.add(0.0, np.array([2.0]))
    assert history.column(0)[1] == pytest.approx([2.0])


def test_empty_history_has_no_samples():
    ages, values = History(length=3, width=1).column(0)
    assert len(ages) == len(values) == 0


def test_rhythm_is_due_once_per_period_and_does_not_catch_up():
    rhythm = Rhythm(rate=10.0)
    moments = (0.0, 0.05, 0.11, 1.0, 1.01, 1.11)
    assert [rhythm.due(now) for now in moments] == [True, False, True, True, False, True]
