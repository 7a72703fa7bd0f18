"""Velocities and accelerations from positions, one instant for every channel.

An estimator adds what encoders, gyroscopes, accelerometers and force sensors
say about one instant. A filter that delays one of them more than another makes
a force out of every movement. So every method here looks at the newest samples
of all channels and tells what they say about one instant, ``delay`` before the
newest: the triweight window (``Kernel``, the default), the adaptive window
(``AdaptiveWindow``) and a Kalman filter (``KalmanWindow``).

The default sends all channels through the same window g, which is even (linear
phase) and whose delay is therefore exact:

    x -> g * x,    dx/dt -> g' * x,    d2x/dt2 -> g'' * x.

The window is the triweight g(t) ~ (1 - (t/h)^2)^3 for |t| < h. It is among the
least noisy that also end smoothly: the variance of g'' is 1.6 times that of the
least-squares parabola, which ends in a jump and leaks.
"""

from abc import ABC, abstractmethod
from dataclasses import dataclass
from functools import cached_property
from typing import Protocol

import numpy as np

Array = np.ndarray

LEAST = 3  # samples on each side: the second derivative has four moments to set right
CHUNK = 16  # windows of a log that are looked at together; more do not fit into the cache


class Method(Protocol):
    """How values and derivatives of one instant are found in a window of samples.

    Attributes:
        delay: Age of that instant [s], the same for all channels and at all times.
        side: The same in samples.
        length: Samples in the window.
    """

    @property
    def delay(self) -> float: ...
    @property
    def side(self) -> int: ...
    @property
    def length(self) -> int: ...

    def of(self, window: Array) -> Array:
        """Return value, first and second derivative at the instant.

        Args:
            window: (length, columns), oldest sample first; the columns are the
                channels, or the channels of several windows side by side.

        Returns:
            (3, columns) [the channel's unit, per s, per s^2].
        """
        ...


class Weights(ABC):
    """A method whose results are weighted sums of the samples, with ``taps`` (3, length)."""

    period: float
    taps: Array

    @property
    @abstractmethod
    def side(self) -> int:
        """Age of the instant described, in samples."""

    def of(self, window: Array) -> Array:
        """Value, first and second derivative at the instant described, (3, columns)."""
        return self.taps @ window

    def along(self, samples: Array) -> Array:
        """The same of every window within up to ``CHUNK + length - 1`` samples, (3, windows, …)."""
        count = len(samples) - self.taps.shape[1] + 1
        band = self._band[:, :count, : len(samples)].reshape(3 * count, -1)
        return (band @ samples).reshape(3, count, -1)

    @cached_property
    def _band(self) -> Array:
        """The taps, one sample later in every row, (3, CHUNK, CHUNK + length - 1)."""
        length = self.taps.shape[1]
        band = np.zeros((3, CHUNK, CHUNK + length - 1))
        for row in range(CHUNK):
            band[:, row, row : row + length] = self.taps
        return band

    @cached_property
    def noise_gain(self) -> Array:
        """Standard deviation of the three results for white noise of one per sample, (3,)."""
        return np.linalg.norm(self.taps, axis=1)

    def response(self, frequency: float) -> Array:
        """Complex gain of the three results at a frequency [Hz], delay taken out, (3,)."""
        return self.responses(np.array([frequency]))[:, 0]

    def responses(self, frequencies: Array) -> Array:
        """The same at many frequencies, (3, f)."""
        age = (np.arange(self.taps.shape[1]) - self.taps.shape[1] + 1 + self.side) * self.period
        return self.taps @ np.exp(2j * np.pi * np.outer(age, frequencies))


class Centred:
    """A window whose results describe the instant at its centre."""

    period: float
    delay: float

    @property
    def side(self) -> int:
        """Samples on each side of the instant described."""
        return round(self.delay / self.period)

    @property
    def length(self) -> int:
        """Samples in the window."""
        return 2 * self.side + 1


@dataclass(frozen=True)
class Kernel(Centred, Weights):
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


def _with_moments(taps: Array, window: Array, x: Array, moments: dict[int, float]) -> Array:
    """Add a polynomial times the window to ``taps``, so that it has the moments given."""
    powers = np.stack([x**power for power in moments])
    missing = np.array(list(moments.values())) - powers @ taps
    return taps + window * (np.linalg.solve((powers * window) @ powers.T, missing) @ powers)


class Differentiator:
    """A method applied to a stream of samples.

    Args:
        method: What is done with the window of the newest samples.
        channels: Number of values per sample.
    """

    def __init__(self, method: Method, channels: int):
        self.method = method
        self.count = 0  # samples since the start or the last reset
        self._length = method.length
        # every row is stored twice, so that the window is always one contiguous block
        self._rows = np.zeros((2 * method.length, channels))
        self._next = 0

    @property
    def delay(self) -> float:
        """Age of the instant that the results describe [s]."""
        return self.method.delay

    @property
    def full(self) -> bool:
        """Whether the window holds samples only from after the last reset."""
        return self.count >= self._length

    @property
    def newest(self) -> Array:
        """The last sample put, (channels,)."""
        return self._rows[self._next - 1 + self._length]

    @property
    def extrapolated(self) -> Array:
        """The next sample, were the last two on a straight line, (channels,)."""
        return 2.0 * self.newest - self._rows[self._next - 2 + self._length]

    def put(self, sample: Array) -> None:
        """Append a sample, (channels,)."""
        row = self._next
        self._rows[row] = sample
        self._rows[row + self._length] = sample
        self._next = row + 1 if row + 1 < self._length else 0
        self.count += 1

    def result(self) -> Array:
        """Value, first and second derivative at ``delay`` ago, (3, channels)."""
        return self.method.of(self._rows[self._next : self._next + self._length])

    def reset(self) -> None:
        """Forget every sample."""
        self.count = 0


def differentiate(samples: Array, method: Method) -> Array:
    """Filter and differentiate a log, with the numbers that the stream would give.

    Args:
        samples: (T, channels), uniformly sampled with the method's period.
        method: What is done with each window.

    Returns:
        (3, T, channels): value, first and second derivative; entry t describes
        sample t - side. The first ``length - 1`` entries are zero: no full window yet.
    """
    result, length = np.zeros((3, *samples.shape)), method.length
    if len(samples) < length:
        return result
    for start in range(0, len(samples) - length + 1, CHUNK):
        some = samples[start : start + CHUNK + length - 1]
        values = method.along(some) if isinstance(method, Weights) else _along(some, method)
        first = start + length - 1
        result[:, first : first + values.shape[1]] = values
    return result


def _along(samples: Array, method: Method) -> Array:
    """Return the results of every window within some samples, (3, windows, channels)."""
    windows = np.lib.stride_tricks.sliding_window_view(samples, method.length, axis=0)
    side_by_side = np.moveaxis(windows, -1, 0).reshape(method.length, -1)
    return method.of(side_by_side).reshape(3, len(windows), -1)
