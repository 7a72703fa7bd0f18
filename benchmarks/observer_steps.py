"""What the observer's benchmarks time: our step, the covariance, and iDynTree's step."""

import numpy as np

from benchmarks.hot import interleaved
from benchmarks.idyntree_observer import IdyntreeObserver
from estimation.observer_covariance import ObserverNoise, propagate
from estimation.torque_observer import TorqueObserver
from robot_model import Robot

STATES = 200
NOISE = ObserverNoise(
    **{"force": 0.3, "moment": 0.02, "acceleration": 0.05, "angular_acceleration": 0.15},
    **{"angular_velocity": 0.01, "joint_velocity": 0.001, "joint_acceleration": 0.1},
    **{"mass": 0.02, "center_of_mass": 0.002},
)


def step_times(robot: Robot, support: str, rounds: int) -> dict[str, list[float]]:
    """Return durations [us] of ``step``, ``covariance`` and the ``peer``'s step.

    From NumPy to NumPy: kinematics, wrenches and torques of all joints.
    """
    observer = TorqueObserver(robot, support)
    peer = IdyntreeObserver(robot, [contact.frame for contact in observer.contacts])
    states = _states(robot)
    steps = {
        "step": observer.step,
        "covariance": lambda *motion: propagate(observer, NOISE, *motion),
        "peer": peer.step,
    }
    inputs = {
        "step": states,
        "covariance": [(*s[:3], *s[4:]) for s in states],
        "peer": [(*s[:3], -s[3], *s[4:]) for s in states],  # iDynTree: child on parent
    }
    return interleaved(steps, inputs, rounds)


def _states(robot: Robot) -> list[tuple[np.ndarray, ...]]:
    rng = np.random.default_rng(0)
    n, k = robot.n, len(robot.ft_sensors)
    shapes = (n, n, n, (k, 6), 3, 3, 3)  # q dq ddq ft gyro acc dgyro
    return [tuple(rng.normal(size=shape) for shape in shapes) for _ in range(STATES)]
