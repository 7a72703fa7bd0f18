"""Robots that come by a description file alone: TALOS (30 joints) and G1 (29)."""

from pathlib import Path

import numpy as np
import pytest

from estimation.observer_covariance import propagate
from estimation.sensor_pipeline import SensorPipeline
from estimation.torque_observer import TorqueObserver
from estimation.wrench_query import WrenchQuery
from robot_model import Robot, load_robot
from robot_sim import Plant
from tests.estimation.observer_noise import NOISE
from tests.estimation.observer_states import random_input

DATA = Path(__file__).parents[1] / "robot_model" / "data"
POINT, FORCE = np.array([0.01, -0.02, 0.03]), np.array([6.0, -9.0, 12.0])  # m, N


@pytest.fixture(scope="module", params=["talos", "g1"])
def robot(request: pytest.FixtureRequest) -> Robot:
    return load_robot(DATA / f"{request.param}.yaml")


def test_the_observer_tells_torques_push_and_support_of_any_robot(robot: Robot) -> None:
    link = robot.subtrees[1].links[-1]
    observer = TorqueObserver(robot, "pole")
    observer.set_contacts([(link, POINT)])
    plant = Plant(robot, "fixed")
    plant.push(link, POINT, FORCE)
    plant.command(robot.home + 0.2 * np.sin(np.arange(robot.n)))
    for _ in range(300):
        plant.step()
    frame, truth = SensorPipeline(robot).step(plant.raw(), plant.time), plant.truth()
    inertial = frame.imu_gyro[0], frame.imu_acc[0], frame.imu_dgyro[0]
    estimate = observer.step(frame.q, frame.dq, frame.ddq, frame.ft, *inertial)
    assert np.abs(truth.dq).max() > 0.1  # rad/s
    np.testing.assert_allclose(estimate.torque, truth.link_torque, atol=1e-9)
    np.testing.assert_allclose(estimate.wrench[1], np.pad(FORCE, (0, 3)), atol=1e-9)
    np.testing.assert_allclose(estimate.wrench[0], truth.support_wrench[0], atol=1e-9)
    np.testing.assert_allclose(estimate.wrench[2:], 0.0, atol=1e-9)


def test_along_its_axis_a_joint_is_as_uncertain_as_its_torque(robot: Robot) -> None:
    observer, state = TorqueObserver(robot, "pole"), random_input(robot, np.random.default_rng(0))
    published = propagate(observer, NOISE, *state[:3], *state[4:])
    query = WrenchQuery(observer, NOISE, *state)
    for name, std in zip(robot.joints, published.torque_std, strict=True):
        axis, moment = (
            robot.urdf.joints[name].axis,
            query.wrench(f"joint:{name}").covariance[3:, 3:],
        )
        assert np.sqrt(axis @ moment @ axis) == pytest.approx(std, rel=1e-9)
