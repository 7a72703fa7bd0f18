"""Slow drift is followed where nothing touches; a push is not learnt away."""

import numpy as np
import pytest

from estimation.contact.limb_monitor import LimbMonitor
from estimation.drift_tracker import DriftLimits, DriftTracker
from estimation.torque_observer import TorqueObserver
from robot_model import load_robot
from robot_sim import Plant

ROBOT = load_robot("icub")
NAMES = tuple(subtree.name for subtree in ROBOT.subtrees)
K, S = len(ROBOT.ft_sensors), len(NAMES)
ARM, PERIOD = ROBOT.ft_sensors.index("l_arm_ft"), 0.1
EVERYWHERE = np.ones(S, dtype=bool)


def tracker(support="pole"):
    observer = TorqueObserver(ROBOT, support)
    supports = {ROBOT.subtree_of(frame) for frame in ROBOT.supports[support]}
    return DriftTracker(observer.graph, supports, DriftLimits())


def follow(tracker, seconds, error, untouched=lambda residual, stamp: EVERYWHERE, start=0):
    """Let minutes pass; ``error`` gives what the sensors read beyond the model, without noise."""
    rng = np.random.default_rng(0)
    noise = np.repeat([0.08, 0.003], 3)  # of the filtered readings
    for i in range(round(seconds / PERIOD)):
        stamp = start + round(i * PERIOD * 1e9)
        residual = tracker.drift - error(i * PERIOD) + noise * rng.normal(size=(K, 6))
        tracker.update(residual, untouched(residual, stamp), np.ones(K, dtype=bool), stamp)
    return tracker.drift


def warming(t):
    return np.full((K, 6), 1.0) * np.repeat([0.004, 1e-4], 3) * t  # 2.4 N in ten minutes


def pushed_error():
    """What a push of 5 N on the left forearm does to the readings, from the plant."""
    plant, observer = Plant(ROBOT, base="fixed"), TorqueObserver(ROBOT, "pole")
    for _ in range(2000):
        plant.step()
    plant.push("l_forearm", np.array([0.0, 0.0, 0.05]), np.array([0.0, 5.0, 0.0]), duration=2.0)
    for _ in range(1800):
        plant.step()
    raw = plant.raw()
    imu = raw.imu_gyro[0], raw.imu_acc[0], raw.imu_dgyro[0]
    estimate = observer.step(raw.q, raw.dq, raw.ddq, raw.ft, *imu)
    return estimate.measured - estimate.predicted


def detector():
    """Flags as the contact detector's: thresholds with hysteresis on each sub-tree's force."""
    monitor = LimbMonitor(NAMES)
    sensors = [0, *range(K)]  # the root's own wrench is not simulated here

    def untouched(residual, stamp):
        force = np.linalg.norm(residual[:, :3], axis=1)[sensors]
        force[0] = 0.0
        flags = monitor.update(force / 0.25, force, stamp, [""] * S)
        return np.array([flag.state == "none" for flag in flags])

    return untouched


def test_thermal_drift_is_followed_within_the_lag_of_the_filter():
    drift = follow(tracker(), 600.0, warming)
    lag = 20.0 * np.repeat([0.004, 1e-4], 3)
    assert (np.abs(drift - warming(600.0)) < 1.5 * lag + np.repeat([0.02, 0.001], 3)).all()


@pytest.mark.parametrize("flags", [detector, lambda: lambda residual, stamp: EVERYWHERE])
def test_a_push_of_5_n_for_five_minutes_is_not_learnt_away(flags):
    error = pushed_error()
    assert np.linalg.norm(error[ARM, :3]) == pytest.approx(5.0, abs=0.1)
    drift = follow(tracker(), 300.0, lambda t: error, flags())
    assert np.abs(drift[ARM, :3]).max() < 0.02
    assert np.abs(drift[ARM, 3:]).max() < 1e-3


def test_during_a_push_the_other_sensors_are_followed_and_afterwards_all():
    error = pushed_error()
    pushing = tracker()
    follow(pushing, 120.0, lambda t: warming(t) + error, detector())
    arms = np.abs(pushing.drift[:, 0] - 0.48)
    assert arms[ARM] > 0.4 and np.delete(arms, ARM).max() < 0.15
    follow(pushing, 120.0, lambda t: warming(120.0), detector(), start=120_000_000_000)
    assert np.abs(pushing.drift[:, 0] - 0.48).max() < 0.05


def test_a_small_push_is_frozen_by_the_evidence_and_learnt_slowly_without_it():
    touch = np.zeros((K, 6))
    touch[ARM, 1] = 1.0
    touched = np.array([name != "l_arm" for name in NAMES])
    assert not follow(tracker(), 120.0, lambda t: touch, lambda *_: touched)[ARM].any()
    drift = follow(tracker(), 20.0, lambda t: touch)
    assert 0.1 < drift[ARM, 1] < 0.01 * 20.0 + 1e-9


def test_all_that_is_learnt_is_bounded():
    drift = follow(tracker(), 900.0, lambda t: warming(t) * 2.0)
    assert drift[:, :3].max() == 5.0 and drift[:, 3:].max() < 0.2


def test_standing_only_the_arms_are_followed_and_without_evidence_nobody():
    standing = tracker("floor")
    follow(standing, 10.0, warming)
    assert np.flatnonzero(standing.followed).tolist() == [0, 1]
    blind = tracker()
    follow(blind, 10.0, warming, lambda *_: ~EVERYWHERE)
    assert not blind.followed.any() and not blind.drift.any()


def test_an_invalid_sensor_and_a_clock_that_jumps_freeze():
    one = tracker()
    follow(one, 10.0, warming)
    before = one.drift
    one.update(np.zeros((K, 6)), EVERYWHERE, np.arange(K) != ARM, 10_000_000_000)
    assert np.flatnonzero(~one.followed).tolist() == [ARM]
    one.update(np.ones((K, 6)), EVERYWHERE, np.ones(K, dtype=bool), 0)
    assert not one.followed.any()
    np.testing.assert_array_equal(one.drift, before)
