"""Attitude of an inertial sensor from its gyro and accelerometer."""

import math
from dataclasses import dataclass

import numpy as np

from estimation.rotations import (
    Quaternion,
    Rows,
    Vector,
    add,
    cross,
    dot,
    exponential,
    heading_of,
    multiply,
    quaternion_of,
    rotate,
    rows_of,
)

ZERO = (0.0, 0.0, 0.0)


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

    rotation: Rows  # R_world_imu
    bias: Vector  # rad/s, in the sensor's axes
    age: float  # s since the start; negative before

    def __init__(self, gains: AttitudeGains, gravity: float = 9.81):
        self._gains = gains
        self._gravity = gravity
        self.reset()

    def reset(self) -> None:
        """Forget everything."""
        self._set((1.0, 0.0, 0.0, 0.0))
        self.bias, self.age = ZERO, -1.0

    def _set(self, quaternion: Quaternion) -> None:
        self._quaternion, self.rotation = quaternion, rows_of(quaternion)

    @property
    def started(self) -> bool:
        return self.age >= 0.0

    def start(self, up: Vector) -> None:
        """Set the tilt from an upward direction; the heading of the x axis is 0."""
        self._set(level(up))
        self.age = 0.0

    def turn_heading(self, angle: float) -> None:
        """Turn the estimate about the vertical by ``angle`` [rad]."""
        self._set(multiply(exponential((0.0, 0.0, angle)), self._quaternion))

    def update(
        self,
        gyro: Vector,
        acc: Vector,
        quat_wxyz: Quaternion | None,
        dt: float,
        heading_error: float = 0.0,
    ) -> None:
        """Advance by one sample.

        Args:
            gyro, acc: Angular velocity and proper acceleration, in sensor axes.
            quat_wxyz: The sensor's own orientation, whose heading is not used; then
                the accelerometer is not.
            dt: Time since the last sample [s].
            heading_error: Reference minus estimated heading [rad].
        """
        gains, up = self._gains, self.rotation[2]
        trust = (
            self._trust(acc) * self._early(gains.tilt) if quat_wxyz is None else gains.orientation
        )
        rate = add(add(gyro, self.bias, -1.0), cross(measured_up(acc, quat_wxyz), up), trust)
        rate = add(rate, up, gains.heading * heading_error)
        self._set(multiply(self._quaternion, exponential([dt * w for w in rate])))
        self.age += dt

    def learn_bias(self, gyro: Vector, reference: Vector, dt: float) -> None:
        """Pull the bias towards ``gyro - reference``."""
        pull = min(1.0, self._early(self._gains.bias) * dt)
        error = add(add(gyro, reference, -1.0), self.bias, -1.0)
        self.bias = add(self.bias, error, pull)

    def _early(self, gain: float) -> float:
        """At first a running mean is faster than any fixed gain."""
        return max(gain, 1.0 / (self.age + 0.2))

    def _trust(self, acc: Vector) -> float:
        """Fade the accelerometer's pull with what cannot be gravity."""
        excess = abs(math.hypot(*acc) - self._gravity)
        return max(0.0, 1.0 - excess / self._gains.acceleration_band)


def measured_up(acc: Vector, quat_wxyz: Quaternion | None = None) -> list[float]:
    """Return the upward unit vector in sensor axes."""
    if quat_wxyz is not None:
        return rows_of(quat_wxyz)[2]
    norm = max(math.hypot(*acc), 1e-3)
    return [a / norm for a in acc]


def level(up: Vector) -> Quaternion:
    """Return the rotation R_world_imu with the unit vector ``up`` upwards and x at heading 0."""
    ahead = (1.0, 0.0, 0.0) if abs(up[0]) < 0.9 else (0.0, 0.0, 1.0)
    forward = add(ahead, up, -dot(ahead, up))
    norm = math.hypot(*forward)
    forward = [a / norm for a in forward]
    w, x, y, z = quaternion_of(np.array([forward, cross(up, forward), up])).tolist()
    axis = rotate(rows_of((w, x, y, z)), (1.0, 0.0, 0.0))
    return multiply(exponential((0.0, 0.0, -heading_of(axis))), (w, x, y, z))
