"""Gains and thresholds of the residuals, as a service sets them while it runs."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from estimation.residual.residual_bank import ResidualBank, ResidualSettings
from estimation.sensor_pipeline import SensorPipeline
from robot_model import Robot
from robot_sim import Plant

SETTINGS = ResidualSettings(classical=True)


@pytest.fixture
def bank(robot: Robot) -> ResidualBank:
    return ResidualBank(robot, "floor", SETTINGS)


def thresholds(bank: ResidualBank) -> np.ndarray:
    message = bank.message()
    return np.concatenate((message.threshold_external, message.threshold_internal))


def test_thresholds_follow_the_settings_at_once_before_a_tare_and_after(
    robot: Robot, bank: ResidualBank
) -> None:
    n = robot.n
    floor = np.concatenate((np.repeat([2.0, 0.5], 3), np.full(n, 0.3)))
    np.testing.assert_array_equal(thresholds(bank), floor)
    bank.configure(replace(SETTINGS, internal_floor=1.5))
    assert (thresholds(bank)[6:] == 1.5).all()
    quiet = SimpleNamespace(residual_mean=np.zeros(6 + 2 * n), residual_std=np.ones(6 + 2 * n))
    bank.tare(quiet)  # type: ignore[arg-type]
    assert (thresholds(bank) == 6.0).all()
    bank.configure(replace(SETTINGS, sigmas=3.0, force_floor=7.0))
    np.testing.assert_array_equal(thresholds(bank), np.repeat([7.0, 3.0], [3, 3 + n]))


@pytest.mark.parametrize(("support", "base"), [("floor", "free"), ("pole", "fixed")])
def test_a_single_joint_may_have_a_gain_of_its_own(robot: Robot, support: str, base: str) -> None:
    joint = robot.joints.index("l_elbow")
    quick = replace(SETTINGS, joint_gains={"l_elbow": 100.0})
    plain, other = (ResidualBank(robot, support, each) for each in (SETTINGS, quick))
    plant, pipeline = Plant(robot, base), SensorPipeline(robot)  # type: ignore[arg-type]
    plant.push("l_hand", np.zeros(3), np.array([0.0, 0.0, -10.0]))
    for _ in range(30):
        plant.step()
        frame = pipeline.step(plant.raw(), plant.time)
        for bank in (plain, other):
            bank.step(frame, plant.time, np.array([0.0, 0.0, 1.0]))
    slow, fast = (bank.values[-robot.n :] for bank in (plain, other))  # classical
    assert np.abs(fast[joint]) > 1.5 * np.abs(slow[joint]) > 0.1
    np.testing.assert_array_equal(np.delete(fast, joint), np.delete(slow, joint))


def test_a_gain_of_an_unknown_joint_is_refused_and_changes_nothing(bank: ResidualBank) -> None:
    with pytest.raises(LookupError, match="no joint 'l_elbwo'; did you mean 'l_elbow'"):
        bank.configure(replace(SETTINGS, internal_floor=9.0, joint_gains={"l_elbwo": 10.0}))
    assert thresholds(bank)[6:].max() == 0.3
