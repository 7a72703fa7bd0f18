"""Tare: what a resting robot reveals about its sensors' offsets, and what it does not."""

from dataclasses import replace

import numpy as np
import pytest

from estimation.resting import MovingError, RestingAverage, StillnessLimits, TareError
from estimation.sensor_pipeline import SensorPipeline
from estimation.tare import OffsetLimits, Tare, stance_supports
from estimation.torque_observer import TorqueObserver
from robot_sim import Plant
from tests.estimation.one_foot import FOOT, on_one_foot

LIMITS = StillnessLimits(joint_velocity=0.02, joint_travel=0.02, angular_velocity=0.05)
ARMS = [0, 1]


@pytest.fixture(scope="module")
def biases():
    rng = np.random.default_rng(3)
    return np.hstack([rng.uniform(-2.0, 2.0, (6, 3)), rng.uniform(-0.06, 0.06, (6, 3))])


@pytest.fixture(scope="module")
def standing(robot):
    plant = Plant(robot)
    for _ in range(6000):
        plant.step()
    return plant


@pytest.fixture(scope="module")
def hanging(robot):
    plant = Plant(robot, base="fixed")
    for _ in range(6000):
        plant.step()
    return plant


def rest(plant, biases, samples=1000):
    average = RestingAverage(plant.robot.joints, LIMITS)
    for _ in range(samples):
        plant.step()
        raw = plant.raw()
        average.add(raw.q, raw.dq, raw.ft + biases, raw.imu_gyro[0], raw.imu_acc[0])
    return average.mean()


def tare(plant, biases, support):
    observer = TorqueObserver(plant.robot, support)
    mean = rest(plant, biases)
    return observer, Tare(observer.graph, 2.0, 0.06).solve(mean, support, observer.offset)


def test_on_two_feet_the_arms_are_tared(standing, biases):
    _, result = tare(standing, biases, "floor")
    np.testing.assert_allclose(result.offset[ARMS], biases[ARMS], atol=5e-3)
    assert result.tared == ("l_arm_ft", "r_arm_ft")


def test_on_two_feet_hips_agree_with_feet_and_the_sum_of_the_feet_is_right(standing, biases):
    observer, result = tare(standing, biases, "floor")
    raw = standing.raw()
    observer.offset = result.offset
    imu = raw.imu_gyro[0], raw.imu_acc[0], raw.imu_dgyro[0]
    estimate = observer.step(raw.q, raw.dq, raw.ddq, raw.ft + biases, *imu)
    untouched = [standing.robot.subtree_of(name) for name in ("l_upper_leg", "r_upper_leg")]
    assert np.abs(estimate.subtree_wrench[[0, *untouched]]).max() < 0.05
    assert np.abs(estimate.torque - standing.truth().link_torque).max() < 2.0


def test_the_difference_between_the_feet_stays_and_the_reply_says_so(standing, biases):
    _, result = tare(standing, biases, "floor")
    assert ("l_leg_ft", "l_foot_ft") in result.relative
    assert set(result.unobservable) == {"l_leg_ft", "r_leg_ft", "l_foot_ft", "r_foot_ft"}
    assert "cannot be observed" in result.message and "l_sole and r_sole" in result.message


def test_the_sum_of_the_feet_bears_the_robot(standing, biases):
    observer, result = tare(standing, biases, "floor")
    observer.offset = result.offset
    raw, truth = standing.raw(), standing.truth()
    imu = raw.imu_gyro[0], raw.imu_acc[0], raw.imu_dgyro[0]
    estimate = observer.step(raw.q, raw.dq, raw.ddq, raw.ft + biases, *imu)
    feet = [standing.robot.subtree_of(frame) for frame in truth.support_frames]
    # Both soles lie flat, so that their axes are parallel.
    sums = estimate.wrench[feet, :3].sum(axis=0), truth.support_wrench[:, :3].sum(axis=0)
    np.testing.assert_allclose(*sums, atol=0.1)


def test_on_the_pole_every_sensor_is_tared(hanging, biases):
    _, result = tare(hanging, biases, "pole")
    np.testing.assert_allclose(result.offset, biases, atol=2e-3)
    assert result.tared == hanging.robot.ft_sensors and not result.unobservable


def test_on_one_foot_every_sensor_is_tared(robot, biases):
    plant = Plant(on_one_foot(robot))
    for _ in range(2000):
        plant.step()
    mean, truth = rest(plant, biases), plant.truth()
    assert truth.support_frames == [FOOT] and not truth.fallen
    assert np.abs(mean.ft - biases)[4, 2] > 250.0  # the left foot bears the robot
    observer = TorqueObserver(robot)
    result = Tare(observer.graph, 2.0, 0.06).solve(mean, FOOT, observer.offset)
    np.testing.assert_allclose(result.offset, biases, atol=0.1)  # it still sways a little
    assert result.tared == robot.ft_sensors and result.supports == (FOOT,)


def test_a_stance_that_was_not_taken_is_refused_by_the_size_of_the_offsets(standing, biases):
    observer = TorqueObserver(standing.robot)
    mean = rest(standing, biases, 100)
    result = Tare(observer.graph, 2.0, 0.06).solve(mean, "l_sole", observer.offset)
    limits = OffsetLimits(force=40.0, moment=10.0)
    with pytest.raises(TareError, match="N on r_.*, limit 40 N; is the robot borne by l_sole"):
        result.check(standing.robot.ft_sensors, limits)
    with pytest.raises(TareError, match="limit 40 N; is the robot borne by nothing alone"):
        replace(result, supports=()).check(standing.robot.ft_sensors, limits)


def test_an_unknown_stance_is_refused_with_those_that_exist(robot):
    with pytest.raises(LookupError, match="no stance 'l_hand'; .*floor.*pole.*l_sole.*r_sole"):
        stance_supports(robot, "l_hand")


def realistic(robot, base, settle):
    """Mean of a second of rest as the sensor server gives it, and the true offsets."""
    plant = Plant(robot, base=base, profile="realistic", seed=0)
    pipeline = SensorPipeline(robot)
    average = RestingAverage(robot.joints, LIMITS, robot.ft_sensors)
    error = np.zeros((6, 6))
    for i in range(settle + 1000):
        plant.step()
        raw = plant.raw()
        frame = pipeline.step(raw, plant.time)
        error += (raw.ft - plant.truth().ft) if i < 1000 else 0.0
        if i >= settle:
            average.add(frame.q, frame.dq, frame.ft, frame.imu_gyro[0], frame.imu_acc[0])
    assert not plant.fallen
    return average.mean(), error / 1000


def test_with_realistic_noise_the_offsets_on_the_pole_are_found(robot):
    mean, bias = realistic(robot, "fixed", 1500)
    solver = Tare(TorqueObserver(robot).graph, 2.0, 0.06)
    error = np.abs(solver.solve(mean, "pole", np.zeros((6, 6))).offset - bias)
    assert error[:, :3].max() < 0.3 and error[:, 3:].max() < 0.06
    assert np.abs(bias[:, :3]).max() > 1.0
    np.testing.assert_allclose(mean.spread[:, :3], 0.05, atol=0.03)


def test_with_realistic_noise_the_offsets_on_one_foot_are_found(robot):
    mean, bias = realistic(on_one_foot(robot), "free", 2000)
    solver = Tare(TorqueObserver(robot).graph, 2.0, 0.06)
    error = np.abs(solver.solve(mean, FOOT, np.zeros((6, 6))).offset - bias)
    # the accelerometer's bias tilts the weight that the standing leg bears
    bearing = [robot.ft_sensors.index(name) for name in ("l_leg_ft", "l_foot_ft")]
    assert error[bearing, :3].max() < 2.0 and error[bearing, 3:].max() < 1.0
    assert np.delete(error, bearing, axis=0)[:, :3].max() < 0.3


def test_with_realistic_noise_arms_and_the_sum_of_the_feet_are_found_on_two_feet(robot):
    mean, bias = realistic(robot, "free", 3000)
    solver = Tare(TorqueObserver(robot).graph, 2.0, 0.06)
    error = solver.solve(mean, "floor", np.zeros((6, 6))).offset - bias
    assert np.abs(error[ARMS, :3]).max() < 0.2 and np.abs(error[ARMS, 3:]).max() < 0.02
    feet = [robot.ft_sensors.index(name) for name in ("l_foot_ft", "r_foot_ft")]
    assert np.abs(error[feet, :3].sum(axis=0)).max() < 2.0


def test_a_reading_that_varies_is_refused_with_its_sensor(robot):
    limits = replace(LIMITS, force_spread=1.0)
    average = RestingAverage(robot.joints, limits, robot.ft_sensors)
    for i in range(10):
        ft = np.zeros((6, 6))
        ft[1, 2] = 4.0 * (i % 2)
        average.add(np.zeros(robot.n), np.zeros(robot.n), ft, np.zeros(3), np.zeros(3))
    with pytest.raises(
        MovingError, match=r"is not at rest: r_arm_ft varies by 2.000 N \(std\), limit 1 N"
    ):
        average.mean()


def test_too_few_samples_are_no_tare(robot):
    average = RestingAverage(robot.joints, LIMITS, robot.ft_sensors, least=20)
    average.add(np.zeros(robot.n), np.zeros(robot.n), np.zeros((6, 6)), np.zeros(3), np.zeros(3))
    with pytest.raises(MovingError, match="1 complete samples came, expected 20"):
        average.mean()


def test_a_second_tare_changes_nothing(standing, biases):
    observer = TorqueObserver(standing.robot)
    mean = rest(standing, biases)
    solver = Tare(observer.graph, 2.0, 0.06)
    first = solver.solve(mean, "floor", observer.offset)
    second = solver.solve(mean, "floor", first.offset)
    np.testing.assert_allclose(second.offset, first.offset, atol=1e-9)


@pytest.mark.parametrize(
    ("dq", "gyro", "drift", "text"),
    [
        (0.1, 0.0, 0.0, "neck_pitch at 0.100 rad/s"),
        (0.0, 0.2, 0.0, "turns: the gyro at 0.200 rad/s, limit 0.05 rad/s"),
        (0.0, 0.0, 0.01, "neck_pitch by 0.0"),
    ],
)
def test_a_moving_robot_is_refused(robot, dq, gyro, drift, text):
    average = RestingAverage(robot.joints, LIMITS)
    joint = np.eye(robot.n)[robot.joints.index("neck_pitch")]
    for i in range(10):
        turning = np.array([0.0, 0.0, gyro])
        average.add(i * drift * joint, dq * joint, np.zeros((6, 6)), turning, np.zeros(3))
    with pytest.raises(MovingError, match=text):
        average.mean()


def test_without_samples_there_is_no_tare(robot):
    with pytest.raises(MovingError, match="no complete sample"):
        RestingAverage(robot.joints, LIMITS).mean()
