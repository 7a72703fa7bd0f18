"""The observer over a block of samples gives the numbers of its steps."""

import numpy as np
import pytest

from estimation.contact_set import Touch
from estimation.offline.block_observer import BlockObserver
from estimation.offline.fixed_link import rooted_at
from estimation.offline.sensor_log import SensorBlock
from estimation.torque_observer import TorqueObserver
from robot_model import Robot, load_robot
from tests.estimation.observer_states import ObserverInput, random_input


def block_of(robot: Robot, states: list[ObserverInput]) -> SensorBlock:
    size = len(states)
    q, dq, ddq, ft, gyro, acc, dgyro = map(np.array, zip(*states, strict=True))
    flags = {"joint_valid": robot.n, "ft_valid": len(robot.ft_sensors), "imu_valid": 1}
    return SensorBlock(
        rows=slice(0, size),
        stamp=np.arange(size),
        q=q,
        dq=dq,
        ddq=ddq,
        motor_torque=np.zeros_like(q),
        ft=ft,
        imu_gyro=gyro[:, None],
        imu_acc=acc[:, None],
        imu_dgyro=dgyro[:, None],
        motor_torque_valid=False,
        **{name: np.ones((size, width), dtype=bool) for name, width in flags.items()},
    )


@pytest.mark.parametrize("source", ["head_imu_0", "l_foot"])  # on either side of the sensors
def test_blocks_of_any_length_give_the_numbers_of_single_steps(source):
    robot = rooted_at(load_robot("icub"), source)
    observer = TorqueObserver(robot)
    observer.offset = np.random.default_rng(1).normal(size=observer.offset.shape)
    observer.set_contacts([Touch("l_forearm", np.array([0.0, 0.01, 0.02]))])
    rng, over = np.random.default_rng(2), BlockObserver(observer)
    for size in (5, 5, 1, 8):
        states = [random_input(robot, rng) for _ in range(size)]
        found = over.observe(block_of(robot, states))
        for row, state in enumerate(states):
            step = observer.step(*state)
            np.testing.assert_allclose(found.torque[row], step.torque, atol=1e-9)
            np.testing.assert_allclose(found.wrench[row], step.wrench, atol=1e-9)
            np.testing.assert_allclose(found.predicted[row], step.predicted, atol=1e-9)
