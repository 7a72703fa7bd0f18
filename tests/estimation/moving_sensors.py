"""Exact readings of inertial sensors anywhere on a robot in random motion."""

import numpy as np
import pinocchio as pin

from robot_model import Robot, build_tree
from robot_model.messages import SensorFrame
from tests.estimation.observer_states import ObserverInput, random_input

UP = np.array([0.0, 0.0, 9.81])


def moving_frame(robot: Robot, rng: np.random.Generator, still: bool = False) -> SensorFrame:
    """Return a sensor frame with every one of ``imus`` exact; F/T readings are random.

    The base link is upright and at rest when ``still``, else anyhow.
    """
    state = random_input(robot, rng)
    pose, twist, rate = pin.SE3.Identity(), np.zeros(6), np.zeros(6)
    if not still:
        pose = pin.SE3(pin.exp3(rng.normal(size=3)), rng.normal(size=3))
        twist, rate = rng.normal(size=6), 3.0 * rng.normal(size=6)
    return _frame(robot, state, pose, twist, rate)


def resting_frame(robot: Robot, rng: np.random.Generator) -> SensorFrame:
    """Return the frame of a robot at rest in a random posture, its base link upright."""
    state, still = random_input(robot, rng), np.zeros(robot.n)
    state = state._replace(dq=still, ddq=still)
    return _frame(robot, state, pin.SE3.Identity(), *np.zeros((2, 6)))


def _frame(
    robot: Robot, state: ObserverInput, pose: pin.SE3, twist: np.ndarray, rate: np.ndarray
) -> SensorFrame:
    tree = build_tree(robot, robot.base_link)
    model, data = tree.model, tree.model.createData()
    motion = tree.velocity(state.dq, twist), tree.velocity(state.ddq, rate)
    pin.forwardKinematics(model, data, tree.configuration(state.q, pose), *motion)
    readings = np.array([_read(model, data, tree.frame_id(name)) for name in robot.imus])
    return SensorFrame(
        q=state.q,
        dq=state.dq,
        ddq=state.ddq,
        motor_torque=np.zeros(robot.n),
        ft=state.ft,
        imu_gyro=readings[:, 0],
        imu_acc=readings[:, 1],
        imu_dgyro=readings[:, 2],
        imu_quat_wxyz=None,
        joint_valid=np.ones(robot.n, dtype=bool),
        ft_valid=np.ones(len(robot.ft_sensors), dtype=bool),
        imu_valid=np.ones(len(robot.imus), dtype=bool),
    )


def _read(model: pin.Model, data: pin.Data, frame: int) -> list[np.ndarray]:
    place, local = pin.updateFramePlacement(model, data, frame), pin.ReferenceFrame.LOCAL
    twist = pin.getFrameVelocity(model, data, frame, local)
    rate = pin.getFrameClassicalAcceleration(model, data, frame, local)
    return [twist.angular, rate.linear + place.rotation.T @ UP, rate.angular]
