"""Attitude of an inertial sensor from its gyro and accelerometer."""

import math
from dataclasses import dataclass

import numpy as np

from estimation.rotations import cross, heading_of, orthonormal, rotation_vector, up_of

UP = np.array([0.0, 0.0, 1.0])


@dataclass(frozen=True)
class AttitudeGains:
    """Gains of the complementary filter."""

    tilt: float  # 1/s, pull of the accelerometer
    orientation: float  # 1/s, pull of the sensor's own orientation where it gives one
    heading: float  # 1/s, pull of a heading reference
    bias: float  # 1/s, learning of the gyro's bias
    acceleration_band: float  # m/s^2, how much more than gravity ends the accelerometer's pull


class AttitudeFilter:
    """Complementary filter on SO(3) with gyro bias.

    The gyro turns the estimate; a measured upward direction corrects the tilt, and a
    reference the heading (explicit form of Mahony, Hamel, Pflimlin, "Nonlinear
    Complementary Filters on the Special Orthogonal Group", IEEE TAC 53(5), 2008). The
    gyro's bias is learnt from a reference of the angular velocity instead of from the
    corrections: the supports give one, and it is much faster.
    """

    rotation: np.ndarray  # (3, 3) R_world_imu
    bias: np.ndarray  # (3,) rad/s, in the sensor's axes
    age: float  # s since the start; negative before

    def __init__(self, gains: AttitudeGains, gravity: float = 9.81):
        self._gains = gains
        self._gravity = gravity
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self.rotation, self.bias, self.age = np.eye(3), np.zeros(3), -1.0

    @property
    def started(self) -> bool:
        return self.age >= 0.0

    def start(self, up: np.ndarray) -> None:
        """Set the tilt from an upward direction (3,); the heading of the x axis is 0."""
        self.rotation = level_rotation(up)
        self.age = 0.0

    def turn_heading(self, angle: float) -> None:
        """Turn the estimate about the vertical by ``angle`` [rad]."""
        self.rotation = rotation_vector(angle * UP) @ self.rotation

    def update(
        self,
        gyro: np.ndarray,
        acc: np.ndarray,
        quat_wxyz: np.ndarray | None,
        dt: float,
        heading_error: float = 0.0,
    ) -> None:
        """Advance by one sample.

        Args:
            gyro, acc: Angular velocity and proper acceleration, (3,) in sensor axes.
            quat_wxyz: The sensor's own orientation (4,), whose heading is not used; then
                the accelerometer is not.
            dt: Time since the last sample [s].
            heading_error: Reference minus estimated heading [rad].
        """
        gains, up = self._gains, self.rotation[2]
        if quat_wxyz is None:
            pull = self._trust(acc) * self._early(gains.tilt) * cross(measured_up(acc), up)
        else:
            pull = gains.orientation * cross(measured_up(acc, quat_wxyz), up)
        pull = pull + gains.heading * heading_error * up
        turn = rotation_vector((gyro - self.bias + pull) * dt)
        self.rotation = orthonormal(self.rotation @ turn)
        self.age += dt

    def learn_bias(self, gyro: np.ndarray, reference: np.ndarray, dt: float) -> None:
        """Pull the bias towards ``gyro - reference`` (3,)."""
        gain = self._early(self._gains.bias)
        self.bias = self.bias + min(1.0, gain * dt) * (gyro - reference - self.bias)

    def _early(self, gain: float) -> float:
        """At first a running mean is faster than any fixed gain."""
        return max(gain, 1.0 / (self.age + 0.2))

    def _trust(self, acc: np.ndarray) -> float:
        """Fade the accelerometer's pull with what cannot be gravity."""
        excess = abs(math.hypot(*acc.tolist()) - self._gravity)
        return max(0.0, 1.0 - excess / self._gains.acceleration_band)


def measured_up(acc: np.ndarray, quat_wxyz: np.ndarray | None = None) -> np.ndarray:
    """Return the upward unit vector (3,) in sensor axes."""
    if quat_wxyz is not None:
        return up_of(quat_wxyz)
    return acc / max(math.hypot(*acc.tolist()), 1e-3)


def level_rotation(up: np.ndarray) -> np.ndarray:
    """Return R_world_imu (3, 3) with the unit vector ``up`` upwards and x at heading 0."""
    ahead = np.array([1.0, 0.0, 0.0]) if abs(up[0]) < 0.9 else UP
    forward = ahead - (ahead @ up) * up
    forward /= np.linalg.norm(forward)
    rotation = np.vstack([forward, cross(up, forward), up])
    return rotation_vector(-heading_of(rotation) * UP) @ rotation
