"""Where the observer's motion comes from: any inertial sensor, a fixed link, or all sensors."""

from typing import NamedTuple

import numpy as np

from estimation.inertial_fusion import FrameMotion, InertialFusion, InertialNoise
from robot_model import Robot
from robot_model.inertial import InertialSensor
from robot_model.messages import SensorFrame
from robot_model.names import did_you_mean

Array = np.ndarray
FIRST, FUSION, FIXED = "first", "fusion", "fixed:"
CERTAIN = 0.01  # factor on the sensors' noise of a link that is said to stand still


class SourceMotion(NamedTuple):
    """Motion of the observer's root; the root stays where it is, whatever the source."""

    motion: FrameMotion
    valid: bool


class KinematicSource:
    """Transports the motion of a source to the first inertial sensor, the observer's root.

    That is re-rooting the graph at the source (Fumagalli, section 3.3) without building
    it anew: the observer's pass from the root back through the same joints undoes it.

    Args:
        robot: The robot.
        name: An inertial sensor; ``fixed:<link>`` for a link or frame that stands still;
            or ``fusion`` for all sensors, weighted (see ``InertialFusion``).
        gravity: (3,) in the axes of the fixed link, m/s^2.
        noise: Noise of sensors and joints.

    Raises:
        LookupError: No such sensor or link.
        ValueError: The sensor has not both a gyro and an accelerometer.
    """

    def __init__(
        self,
        robot: Robot,
        name: str,
        gravity: Array | tuple[float, float, float] = (0.0, 0.0, -9.81),
        noise: InertialNoise | None = None,
    ):
        self.name = name
        self._fixed: tuple[Array, Array, Array] | None = None
        self._rows = np.arange(len(robot.imus))
        sensors = robot.inertial_sensors
        if name.startswith(FIXED):
            sensors = (InertialSensor(_require(robot, name), noise=CERTAIN),)
            still = np.zeros((1, 3))
            self._fixed = still, -np.array([gravity], dtype=float), still
        elif name != FUSION:
            row = _row(robot, name)
            sensors, self._rows = sensors[row : row + 1], np.array([row])
        self._fusion = InertialFusion(robot, sensors, noise, robot.imus[0])
        self._certain = np.ones(1, dtype=bool)
        self._nothing = FrameMotion(*np.zeros((3, 3)))

    def refresh(self, q: Array) -> None:
        """Weigh the sensors anew at a posture, (n,) rad."""
        self._fusion.refresh(q)

    @property
    def covariance(self) -> Array:
        """(6, 6) of the root's [proper, angular] acceleration where it last was."""
        return self._fusion.covariance_at()

    def step(self, frame: SensorFrame) -> SourceMotion:
        """Return the root's motion; invalid, and 0, where no sensor tells it."""
        rows, fusion = self._rows, self._fusion
        valid, readings = self._certain, self._fixed
        if readings is None:
            valid = frame.imu_valid[rows]
            readings = frame.imu_gyro[rows], frame.imu_acc[rows], frame.imu_dgyro[rows]
        usable = fusion.usable(valid, frame.joint_valid)
        base = fusion.step(frame.q, frame.dq, frame.ddq, *readings, usable)
        return SourceMotion(fusion.at() if base.valid else self._nothing, base.valid)


def _require(robot: Robot, name: str) -> str:
    frame = name.removeprefix(FIXED)
    robot.frame(frame)
    return frame


def _row(robot: Robot, name: str) -> int:
    if name not in robot.imus:
        hint = did_you_mean(name, robot.imus)
        others = f"'{FIRST}', '{FUSION}' or '{FIXED}<link>'"
        raise LookupError(f"{robot.name} has no inertial sensor '{name}'{hint}; or {others}")
    row = robot.imus.index(name)
    if not robot.inertial_sensors[row].complete:
        raise ValueError(
            f"'{name}' lacks a gyro or an accelerometer: it is a source in fusion only"
        )
    return row
