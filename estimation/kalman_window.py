"""A Kalman filter of constant acceleration, with a fixed lag and a finite memory.

A channel x is measured with white noise, and its third derivative is white noise:
nothing but the acceleration persists. The gains of a Kalman filter for that model
depend on time alone, never on the measurements, so what it says is a weighted sum of
the samples. The weights are computed once: those of the best estimate of (x, dx, d2x)
at one instant, ``delay`` before the newest sample, from the samples of the ``memory``
and no knowledge before. That is the Kalman filter started afresh on each window and
smoothed backwards by the lag; with a memory of several of its time constants it is the
stationary one. Unlike the recursion it forgets a lost or a wrong sample altogether.

All channels get the same weights, those of the joint positions: weights of their own
would smooth forces more than accelerations, and make a false force of every movement.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

from estimation.differentiation import LEAST, Array, Weights


@dataclass(frozen=True)
class KalmanWindow(Weights):
    """The filter's weights.

    Args:
        period: Time between samples [s].
        delay: Lag: age of the instant that the results describe [s]; rounded to whole
            samples. None at all is the filter itself. Noise and ``lateness`` fall with
            the lag; both are least in the middle of the memory.
        noise: Standard deviation of a sample [the channel's unit].
        jerk: Root of the spectral density of the third derivative
            [the channel's unit per s^3, per root of Hz]; only ``jerk / noise`` matters.
        memory: Age of the oldest sample [s].
    """

    period: float
    delay: float
    noise: float
    jerk: float
    memory: float

    def __post_init__(self) -> None:
        if self.period <= 0.0 or self.noise <= 0.0 or self.jerk <= 0.0 or self.delay < 0.0:
            raise ValueError(
                "period, noise and jerk must be positive and delay not negative, got "
                f"{self.period} s, {self.noise}, {self.jerk}, {self.delay} s"
            )
        if self.length <= self.side + LEAST:
            raise ValueError(
                f"memory must reach at least {LEAST} samples beyond the delay of {self.delay} s, "
                f"got {self.memory} s with period {self.period} s"
            )
        object.__setattr__(self, "delay", self.side * self.period)

    @property
    def side(self) -> int:
        """The lag in samples."""
        return round(self.delay / self.period)

    @property
    def length(self) -> int:
        """Samples in the memory."""
        return round(self.memory / self.period) + 1

    @cached_property
    def taps(self) -> Array:
        """Weights of the newest ``length`` samples, oldest first, (3, length) [1, 1/s, 1/s^2]."""
        return self.covariance @ self._precise.T / self.noise**2

    @cached_property
    def covariance(self) -> Array:
        """Covariance of the error of value and derivatives, if the model is true, (3, 3)."""
        return np.linalg.inv(self._motion.T @ self._precise) * self.noise**2

    @property
    def lateness(self) -> float:
        """How much older than ``delay`` the accelerations of slow motions are [s].

        It is zero in the middle of the memory, small where the lag is long for the
        filter, and makes a short one's stated delay untrue. Constant jerk shows it.
        """
        return -float(self.taps[2] @ self._time**3) / 6.0

    @cached_property
    def _time(self) -> Array:
        """Time of each sample after the instant described [s], (length,)."""
        return (np.arange(self.length) - (self.length - 1 - self.side)) * self.period

    @cached_property
    def _motion(self) -> Array:
        """Samples of a motion without jerk, by its value and derivatives, (length, 3)."""
        return np.stack([self._time**0, self._time, 0.5 * self._time**2], axis=1)

    @cached_property
    def _precise(self) -> Array:
        """Motion weighted by the inverse covariance of the samples, noise as unit, (length, 3)."""
        spread = (self.jerk / self.noise) ** 2 * _jerk_covariance(self._time)
        return np.linalg.solve(spread + np.eye(self.length), self._motion)


def _jerk_covariance(time: Array) -> Array:
    """Covariance of what white jerk of one adds from time 0 on, forwards and backwards, [s^5].

    The integral of (|s| - u)^2 (|t| - u)^2 / 4 over u from 0 to the smaller of both,
    where s and t have the same sign; steps to the two sides are independent.
    """
    age = np.abs(time)
    less = np.minimum.outer(age, age)
    more = np.abs(np.subtract.outer(age, age))
    both = 0.25 * (less**5 / 5.0 + more * less**4 / 2.0 + more**2 * less**3 / 3.0)
    return np.where(np.multiply.outer(time, time) > 0.0, both, 0.0)
