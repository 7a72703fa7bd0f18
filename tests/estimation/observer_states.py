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
    scales = (2.0, 8.0)
    return ObserverInput(
        rng.uniform(lower, upper),
        *(scale * rng.normal(size=n) for scale in scales),
        20.0 * rng.normal(size=(k, 6)),
        *(scale * rng.normal(size=3) for scale in (2.0, 10.0, 5.0)),
    )
