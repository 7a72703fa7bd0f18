"""Random inputs of the torque observer."""

from typing import NamedTuple

import numpy as np

from robot_model import Robot


class ObserverInput(NamedTuple):
    """Arguments of ``TorqueObserver.step``, in its order."""

    q: np.ndarray
    dq: np.ndarray
    ddq: np.ndarray
    ft: np.ndarray
    gyro: np.ndarray
    acc: np.ndarray
    dgyro: np.ndarray


def random_input(robot: Robot, rng: np.random.Generator) -> ObserverInput:
    """Return a state within the joint limits, moving and shaken hard."""
    n, k = robot.n, len(robot.ft_sensors)
    lower, upper = np.maximum(robot.position_lower, -3.0), np.minimum(robot.position_upper, 3.0)
    return ObserverInput(
        q=rng.uniform(lower, upper),
        dq=2.0 * rng.normal(size=n),
        ddq=8.0 * rng.normal(size=n),
        ft=20.0 * rng.normal(size=(k, 6)),
        gyro=2.0 * rng.normal(size=3),
        acc=10.0 * rng.normal(size=3),
        dgyro=5.0 * rng.normal(size=3),
    )
