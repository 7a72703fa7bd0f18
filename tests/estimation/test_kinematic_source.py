"""Any source of the observer's motion gives the same torques; fused, noise weighs less."""

from dataclasses import replace

import numpy as np
import pytest

from estimation.inertial_fusion import InertialFusion, InertialNoise
from estimation.kinematic_source import FUSION, KinematicSource
from estimation.torque_observer import TorqueObserver
from robot_model import Robot, load_robot
from robot_model.inertial import InertialSensor
from robot_model.messages import SensorFrame
from tests.estimation.moving_sensors import moving_frame, resting_frame
from tests.estimation.random_robots import described_robot, random_joints

WHOLE = ("head_imu_0", "root_link", "l_foot", "r_hand_dh_frame", "chest")
BARE = "l_forearm", "r_lower_leg"


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("icub_inertial")


@pytest.fixture(scope="module")
def instrumented(robot) -> Robot:
    """iCub with whole sensors all over, an accelerometer and a gyro by themselves."""
    parts = [InertialSensor(BARE[0], gyro=False), InertialSensor(BARE[1], accelerometer=False)]
    return replace(robot, imus=(*WHOLE, *BARE), inertial={s.name: s for s in parts})


def torques(robot: Robot, frame: SensorFrame, source: KinematicSource) -> np.ndarray:
    motion = source.step(frame)
    assert motion.valid
    observer = TorqueObserver(robot, "pole")
    estimate = observer.step(frame.q, frame.dq, frame.ddq, frame.ft, *motion.motion)
    return np.concatenate([estimate.torque, estimate.wrench.ravel()])


def head_alone(robot: Robot, frame: SensorFrame) -> np.ndarray:
    imu = frame.imu_gyro[0], frame.imu_acc[0], frame.imu_dgyro[0]
    estimate = TorqueObserver(robot, "pole").step(frame.q, frame.dq, frame.ddq, frame.ft, *imu)
    return np.concatenate([estimate.torque, estimate.wrench.ravel()])


@pytest.mark.parametrize("name", [*WHOLE, FUSION])
def test_every_source_gives_the_torques_of_the_head(instrumented, name):
    source = KinematicSource(instrumented, name)
    for seed in range(3):
        frame = moving_frame(instrumented, np.random.default_rng(seed))
        expected = head_alone(instrumented, frame)
        np.testing.assert_allclose(torques(instrumented, frame, source), expected, atol=1e-9)


@pytest.mark.parametrize("link", ["root_link", "base_link"])
def test_a_fixed_link_agrees_with_the_inertial_sensor_of_a_fixed_base(robot, link):
    _, base_m_link = robot.frame(link)
    gravity = tuple(base_m_link.rotation.T @ [0.0, 0.0, -9.81])
    source = KinematicSource(robot, f"fixed:{link}", gravity)
    frame = moving_frame(robot, np.random.default_rng(4), still=True)
    expected = head_alone(robot, frame)
    np.testing.assert_allclose(torques(robot, frame, source), expected, atol=1e-9)


@pytest.mark.parametrize("seed", range(4))
def test_sensors_of_a_random_robot_are_told_apart_by_no_torque(tmp_path, seed):
    rng = np.random.default_rng(seed)
    links = [f"link{i}" for i in (0, 5, 9, 12)]
    robot = described_robot(tmp_path, random_joints(rng, 12, 0.2), links)
    robot = replace(robot, supports={**robot.supports, "pole": ("link0",)})
    frame = moving_frame(robot, rng)
    expected = head_alone(robot, frame)
    for name in (*links, FUSION):
        found = torques(robot, frame, KinematicSource(robot, name))
        np.testing.assert_allclose(found, expected, atol=1e-8 * max(1.0, np.abs(expected).max()))


def test_what_a_sensor_does_not_measure_is_not_looked_at(instrumented):
    frame = moving_frame(instrumented, np.random.default_rng(5))
    source = KinematicSource(instrumented, FUSION)
    expected = torques(instrumented, frame, source)
    frame.imu_gyro[5], frame.imu_dgyro[5], frame.imu_acc[6] = 1e3, 1e3, 1e3
    np.testing.assert_array_equal(torques(instrumented, frame, source), expected)


def test_a_lost_sensor_and_one_beyond_a_lost_joint_drop_out(instrumented):
    frame = moving_frame(instrumented, np.random.default_rng(6))
    expected = head_alone(instrumented, frame)
    frame.imu_acc[3], frame.imu_gyro[2] = 1e3, 1e3
    knee = instrumented.joints.index("l_knee")
    frame.joint_valid[knee] = frame.imu_valid[3] = False
    source = KinematicSource(instrumented, FUSION)
    np.testing.assert_allclose(torques(instrumented, frame, source), expected, atol=1e-9)


def test_without_a_gyro_or_an_accelerometer_nothing_is_known(robot):
    fusion = InertialFusion(robot, robot.inertial_sensors)
    frame = moving_frame(robot, np.random.default_rng(7))
    readings = frame.q, frame.dq, frame.ddq, frame.imu_gyro, frame.imu_acc, frame.imu_dgyro
    gyros = np.array([s.gyro for s in robot.inertial_sensors])
    for valid, reason in ((~gyros, "no gyro"), (gyros & False, "no gyro and no accelerometer")):
        motion = fusion.step(*readings, valid)
        assert not motion.valid and motion.reason == f"{reason} is valid"
        np.testing.assert_array_equal(np.concatenate(motion[:3]), 0.0)
    assert fusion.step(*readings, gyros | True).valid


def test_unknown_sources_are_refused_with_what_exists(robot):
    with pytest.raises(LookupError, match="no inertial sensor 'hed_imu_0'; did you mean 'head_i"):
        KinematicSource(robot, "hed_imu_0")
    with pytest.raises(LookupError, match="no frame 'root_lnk'"):
        KinematicSource(robot, "fixed:root_lnk")
    with pytest.raises(ValueError, match="'l_arm_ft_imu' lacks a gyro or an accelerometer"):
        KinematicSource(robot, "l_arm_ft_imu")


def errors_at_rest(robot: Robot, fusion: InertialFusion, runs: int) -> np.ndarray:
    """Errors (runs, 9) of the base's motion, gyro first, from noise at a posture."""
    noise, rng = fusion.noise, np.random.default_rng(8)
    frame = resting_frame(robot, rng)
    fusion.refresh(frame.q)
    exact = frame.imu_gyro, frame.imu_acc, frame.imu_dgyro
    truth = np.concatenate(fusion.step(frame.q, frame.dq, frame.ddq, *exact)[:3])
    factor = np.array([s.noise for s in fusion.sensors])[:, None]
    sigmas = noise.gyro, noise.acceleration, noise.angular_acceleration
    found = []
    for _ in range(runs):
        wrong = [x + s * factor * rng.normal(size=x.shape)
                 for x, s in zip(exact, sigmas, strict=True)]  # fmt: skip
        dq, ddq = rng.normal(size=(2, robot.n))
        joints = noise.joint_velocity * dq, noise.joint_acceleration * ddq
        found.append(np.concatenate(fusion.step(frame.q, *joints, *wrong)[:3]) - truth)
    return np.array(found)


def test_the_fused_covariance_is_calibrated_and_smaller_than_the_heads(robot):
    noise = InertialNoise()
    fusion = InertialFusion(robot, robot.inertial_sensors, noise)
    found = errors_at_rest(robot, fusion, 1500)
    for block, covariance in (
        (found[:, :3], fusion.angular_covariance),
        (found[:, 3:], fusion.covariance),
    ):
        distance = np.einsum("ri,ij,rj->r", block, np.linalg.inv(covariance), block)
        size = len(covariance)  # mean of chi-square; its standard deviation is sqrt(2 size)
        assert distance.mean() == pytest.approx(size, abs=5.0 * np.sqrt(2 * size / 1500))
    alone = InertialFusion(robot, robot.inertial_sensors[:1], noise)
    alone.refresh(robot.home)
    fusion.refresh(robot.home)
    assert np.linalg.eigvalsh(alone.covariance - fusion.covariance).min() > 0.0
    narrower = alone.angular_covariance - fusion.angular_covariance
    assert np.linalg.eigvalsh(narrower).min() > 0.0
