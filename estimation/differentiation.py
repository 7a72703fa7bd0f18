"""Velocities and accelerations from positions, one filter for every channel.

An estimator adds what encoders, gyroscopes, accelerometers and force sensors
say about one instant. A filter that delays one of them more than another makes
a force out of every movement, so all channels go through the same window g,
which is even (linear phase) and whose delay is therefore exact:

    x -> g * x,    dx/dt -> g' * x,    d2x/dt2 -> g'' * x.

The window is the triweight g(t) ~ (1 - (t/h)^2)^3 for |t| < h. It is among the
least noisy that also end smoothly: the variance of g'' is 1.6 times that of the
least-squares parabola, which ends in a jump and leaks.
"""

from dataclasses import dataclass
from functools import cached_property

import numpy as np

Array = np.ndarray

LEAST = 3  # samples on each side: the second derivative has four moments to set right


@dataclass(frozen=True)
class Kernel:
    """The window and its first two derivatives, sampled.

    Args:
        period: Time between samples [s].
        delay: Age of the instant that the results describe [s]; rounded to
            whole samples. The gain falls to 0.7 at 0.38 / delay [Hz].
    """

    period: float
    delay: float

    def __post_init__(self) -> None:
        if self.period <= 0.0 or round(self.delay / self.period) < LEAST:
            raise ValueError(
                f"a window needs at least {LEAST} samples on each side, got delay {self.delay} s "
                f"with period {self.period} s"
            )
        object.__setattr__(self, "delay", self.side * self.period)

    @cached_property
    def side(self) -> int:
        """Samples on each side of the instant described."""
        return round(self.delay / self.period)

    @property
    def length(self) -> int:
        """Samples in the window."""
        return 2 * self.side + 1

    @cached_property
    def taps(self) -> Array:
        """Weights of the newest ``length`` samples, oldest first, (3, length) [1, 1/s, 1/s^2].

        The derivatives of a sampled window are not the sampled derivatives; their
        moments are set right up to the sixth, and the three rows are one filter
        to 1e-6 of its gain up to 10 Hz.
        """
        x = np.arange(-self.side, self.side + 1) / (self.side + 1)
        half_width = (self.side + 1) * self.period  # [s]
        window = (1.0 - x**2) ** 3
        window /= window.sum()
        second, fourth = window @ x**2, window @ x**4
        slope = x * (1.0 - x**2) ** 2
        slope /= slope @ x
        slope = _with_moments(slope, window, x, {1: 1.0, 3: 3.0 * second, 5: 5.0 * fourth})
        curvature = (1.0 - x**2) * (5.0 * x**2 - 1.0)
        curvature *= 2.0 / (curvature @ x**2)
        moments = {0: 0.0, 2: 2.0, 4: 12.0 * second, 6: 30.0 * fourth}
        curvature = _with_moments(curvature, window, x, moments)
        return np.stack([window, slope / half_width, curvature / half_width**2])

    @cached_property
    def noise_gain(self) -> Array:
        """Standard deviation of the three results for white noise of one per sample, (3,)."""
        return np.linalg.norm(self.taps, axis=1)

    def response(self, frequency: float) -> Array:
        """Complex gain of the three results at a frequency [Hz], delay taken out, (3,)."""
        age = np.arange(-self.side, self.side + 1) * self.period
        return self.taps @ np.exp(2j * np.pi * frequency * age)


def _with_moments(taps: Array, window: Array, x: Array, moments: dict[int, float]) -> Array:
    """Add a polynomial times the window to ``taps``, so that it has the moments given."""
    powers = np.stack([x**power for power in moments])
    missing = np.array(list(moments.values())) - powers @ taps
    return taps + window * (np.linalg.solve((powers * window) @ powers.T, missing) @ powers)


class Differentiator:
    """The kernel applied to a stream of samples.

    Args:
        kernel: Window.
        channels: Number of values per sample.
    """

    def __init__(self, kernel: Kernel, channels: int):
        self.kernel = kernel
        self.count = 0  # samples since the start or the last reset
        # every row is stored twice, so that the window is always one contiguous block
        self._rows = np.zeros((2 * kernel.length, channels))
        self._taps = kernel.taps
        self._next = 0

    @property
    def full(self) -> bool:
        """Whether the window holds samples only from after the last reset."""
        return self.count >= self.kernel.length

    @property
    def newest(self) -> Array:
        """The last sample put, (channels,)."""
        return self._rows[self._next - 1 + self.kernel.length]

    @property
    def extrapolated(self) -> Array:
        """The next sample, were the last two on a straight line, (channels,)."""
        return 2.0 * self.newest - self._rows[self._next - 2 + self.kernel.length]

    def put(self, sample: Array) -> None:
        """Append a sample, (channels,)."""
        row = self._next
        self._rows[row] = sample
        self._rows[row + self.kernel.length] = sample
        self._next = row + 1 if row + 1 < self.kernel.length else 0
        self.count += 1

    def result(self) -> Array:
        """Value, first and second derivative at ``delay`` ago, (3, channels)."""
        return self._taps @ self._rows[self._next : self._next + self.kernel.length]

    def reset(self) -> None:
        """Forget every sample."""
        self.count = 0


def differentiate(samples: Array, kernel: Kernel) -> Array:
    """Filter and differentiate a log, with the numbers that the stream would give.

    Args:
        samples: (T, channels), uniformly sampled with the kernel's period.
        kernel: Window.

    Returns:
        (3, T, channels): value, first and second derivative; entry t describes
        sample t - side. The first ``length - 1`` entries are zero: no full window yet.
    """
    result = np.zeros((3, *samples.shape))
    if len(samples) >= kernel.length:
        windows = np.lib.stride_tricks.sliding_window_view(samples, kernel.length, axis=0)
        result[:, kernel.length - 1 :] = np.moveaxis(windows @ kernel.taps.T, -1, 0)
    return result
