"""States of the limbs over time."""

import numpy as np
import pytest

from estimation.contact.limb_monitor import Levels, LimbFlag, LimbMonitor, contact_probability

MS = 1_000_000


def watch(monitor: LimbMonitor, statistics: list[float], force: float = 5.0) -> list[LimbFlag]:
    """Feed one value per 10 ms to a monitor of one limb."""
    return [
        monitor.update([value], [force], 10 * MS * (i + 1), [""])[0]
        for i, value in enumerate(statistics)
    ]


def test_a_contact_begins_above_the_threshold_and_remembers_its_onset() -> None:
    flags = watch(LimbMonitor(("arm",), Levels(contact=6.0)), [1.0, 5.9, 6.1, 30.0])
    assert [flag.state for flag in flags] == ["none", "none", "contact", "contact"]
    assert [flag.onset for flag in flags] == [0, 0, 30 * MS, 30 * MS]


def test_a_contact_ends_only_well_below_the_threshold_for_a_while() -> None:
    levels = Levels(contact=6.0, release=0.5, release_time=0.02)
    flags = watch(LimbMonitor(("arm",), levels), [9.0, 4.0, 2.0, 4.0, 2.0, 2.0, 2.0])
    assert [flag.state for flag in flags][-4:] == ["contact", "contact", "contact", "none"]


def test_a_hard_contact_is_a_collision_until_it_eases() -> None:
    monitor = LimbMonitor(("arm",), Levels(collision=40.0, collision_release=0.8))
    states = [
        monitor.update([99.0], [force], 10 * MS * (i + 1), [""])[0].state
        for i, force in enumerate([20.0, 41.0, 35.0, 31.0, 35.0])
    ]
    assert states == ["contact", "collision", "collision", "contact", "contact"]


def test_a_limb_that_cannot_be_judged_says_why_and_forgets_its_contact() -> None:
    monitor = LimbMonitor(("arm",))
    watch(monitor, [50.0])
    blind = monitor.update([50.0], [9.0], 20 * MS, ["sensor is invalid"])[0]
    assert (blind.state, blind.valid, blind.reason) == ("none", False, "sensor is invalid")
    assert blind.force == 0.0


def test_a_noisy_quiet_period_raises_a_threshold_and_a_calm_one_does_not_lower_it() -> None:
    monitor = LimbMonitor(("arm", "leg"), Levels(contact=6.0))
    monitor.learn(np.array([1.0, 10.0]))
    np.testing.assert_array_equal(monitor.threshold, [6.0, 15.0])


def test_another_margin_moves_thresholds_at_once() -> None:
    monitor = LimbMonitor(("arm", "leg"), Levels(contact=6.0))
    monitor.learn(np.array([1.0, 10.0]))
    monitor.configure(Levels(contact=6.0, margin=2.0))
    np.testing.assert_array_equal(monitor.threshold, [6.0, 20.0])


def test_at_the_threshold_the_odds_are_even() -> None:
    probability = [contact_probability(value, 6.0) for value in (0.0, 6.0, 40.0)]
    assert probability[0] < 1e-6
    assert probability[1] == pytest.approx(0.5)
    assert probability[2] > 1.0 - 1e-6
