"""A fixed link in the place of an inertial sensor (F section 3.4.1).

A fixed link does not turn, and its proper acceleration is gravity turned round: it is an
inertial sensor whose readings are known. So a robot whose first sensor is that link goes
through the same mathematics.
"""

from dataclasses import replace

import numpy as np

from estimation.graph.graph_kinematics import at_rest
from robot_model import Robot

Array = np.ndarray


def rooted_at(robot: Robot, link: str) -> Robot:
    """Return the robot with a link's (or frame's) motion as its only kinematic source.

    Raises:
        LookupError: The robot has no such link.
    """
    robot.frame(link)
    return replace(robot, imus=(link,))


def fixed_readings(gravity: Array, samples: int) -> dict[str, Array]:
    """Return ``imu_gyro``, ``imu_acc`` and ``imu_dgyro``, (samples, 1, 3), of a fixed link.

    Args:
        gravity: (3,) m/s^2, in the link's axes; (0, 0, -9.81) where its z axis is up.
        samples: Number of samples.
    """
    motion = at_rest(gravity)
    rows = {"imu_gyro": motion.omega, "imu_acc": motion.acceleration, "imu_dgyro": motion.domega}
    return {name: np.tile(row, (samples, 1, 1)) for name, row in rows.items()}


def without_drives(robot: Robot) -> Robot:
    """Return the robot as it is behind its gears: its motor torques are link torques."""
    nothing = {"viscous": np.zeros(robot.n), "coulomb": np.zeros(robot.n)}
    return replace(robot, rotor_inertia=np.zeros((robot.n, robot.n)), **nothing)
