"""Velocity of an inertial sensor in a freely falling frame."""

import numpy as np

Array = np.ndarray


class FreeFallVelocity:
    """Integrates the proper acceleration; needs neither attitude nor gravity.

    In a frame that falls freely there is no gravity, and the proper acceleration is
    the acceleration. Momentum residuals are the same in that frame as on the ground,
    so that an external residual needs no estimate of the base's attitude or velocity.
    The velocity is zeroed from time to time (a change of frame): it would grow by g.
    """

    def __init__(self) -> None:
        self.velocity = (0.0, 0.0, 0.0)  # [m/s] in the sensor's axes
        self._gyro = self._acc = [0.0, 0.0, 0.0]

    @property
    def twist(self) -> Array:
        """Velocity and angular velocity after the last sample, (6,) in the sensor's axes."""
        return np.array([*self.velocity, *self._gyro])

    def reset(self, gyro: Array, acc: Array) -> None:
        """Start in the frame that falls with the sensor at this instant."""
        self.rebase()
        self._gyro, self._acc = gyro.tolist(), acc.tolist()

    def rebase(self) -> None:
        """Move to the frame that falls with the sensor at the instant of the last sample."""
        self.velocity = (0.0, 0.0, 0.0)

    def step(self, gyro: Array, acc: Array, period: float) -> None:
        """Advance ``period`` seconds in which gyro and proper acceleration, (3,) in the
        sensor's axes, changed linearly to these values."""
        (p0, q0, r0), (a0, b0, c0) = self._gyro, self._acc
        self._gyro, self._acc = gyro.tolist(), acc.tolist()
        (p, q, r), (a, b, c) = self._gyro, self._acc
        half = 0.5 * period
        p, q, r = half * (p0 + p), half * (q0 + q), half * (r0 + r)
        a, b, c = half * (a0 + a), half * (b0 + b), half * (c0 + c)
        x, y, z = self.velocity
        # dv/dt = acc - gyro x v, at the middle of the step (np.cross costs 15 us)
        u, v, w = x + 0.5 * a, y + 0.5 * b, z + 0.5 * c
        self.velocity = (x + a - q * w + r * v, y + b - r * u + p * w, z + c - p * v + q * u)
