"""How wrong accelerations are that come from encoders which count in steps.

A joint that passes f counts per second makes an error like a saw tooth of that frequency,
whose harmonics k f have the amplitudes 1 / (pi k) steps. Only where it is fast, and its
harmonics fold all over the band, is that the white noise of 1/12 square step (Bennett,
Spectra of quantized signals, 1948); a filter that differentiates twice passes a slow one's
much better: four times the white noise's deviation at f = 0.6 / delay. Near whole fractions
of the sampling frequency the harmonics fold back to slow ones, but a joint passes those
rates quickly, and that is neglected.
"""

from functools import cache

import numpy as np

from estimation.differentiation import Weights

Array = np.ndarray
HARMONICS = 30
FASTEST = 150.0  # counts/s, beyond which the error is taken as white
UNSTEADY = 15.0  # counts/s, by which a rate may change before somebody looks again
LEAST = 1e-9  # rad; what is less is rounding


@cache
def quantisation_gain(method: Weights) -> tuple[Array, Array]:
    """Return rates [counts/s] and standard deviations of accelerations [1/s^2] per step.

    The worst of all rates within ``UNSTEADY``, and at least what white noise makes: a
    single step, whose pulse has no frequency, counts as a slow motion.
    """
    rates = np.arange(1.0, FASTEST)
    harmonics = np.arange(1, HARMONICS + 1)
    gains = np.abs(method.responses(np.outer(rates, harmonics).ravel())[2])
    power = np.square(gains.reshape(len(rates), -1) / (np.pi * harmonics)).sum(axis=1) / 2.0
    apart = np.abs(rates[:, None] - rates)
    worst = np.where(apart <= UNSTEADY, power, 0.0).max(axis=1)
    white = method.noise_gain[2] ** 2 / 12.0
    worst[rates > FASTEST - UNSTEADY] = white
    return rates, np.sqrt(np.maximum(worst, white))


class EncoderNoise:
    """Learns the step of each encoder from its positions, and tells what it does to ``ddq``.

    The step is the smallest change that was ever seen. A joint that has not moved yet is
    taken to count as the coarsest of those that have.

    Args:
        method: That makes accelerations from positions.
        joints: Their number n.
    """

    def __init__(self, method: Weights, joints: int):
        self._rates, self._gain = quantisation_gain(method)
        self._smallest = np.full(joints, np.inf)
        self._last: Array | None = None
        self._step: Array | None = np.zeros(joints)

    @property
    def step(self) -> Array:
        """Step of each encoder, (n,) rad; 0 while no joint has moved."""
        if self._step is None:
            seen = np.isfinite(self._smallest)
            self._step = np.where(seen, self._smallest, self._smallest[seen].max(initial=0.0))
        return self._step

    def see(self, q: Array) -> None:
        """Take measured positions, (n,) rad."""
        if self._last is not None:
            self._take(np.abs(q - self._last))
        self._last = q

    def learn(self, positions: Array) -> None:
        """Take the positions of a log, (T, n) rad."""
        change = np.abs(np.diff(positions, axis=0))
        self._take(np.where(change < LEAST, np.inf, change).min(axis=0, initial=np.inf))

    def _take(self, change: Array) -> None:
        smaller = (change < self._smallest) & (change > LEAST)
        if smaller.any():
            self._smallest[smaller] = change[smaller]
            self._step = None

    def deviation(self, dq: Array) -> Array:
        """Return the standard deviation of accelerations at velocities dq, (n,) rad/s^2."""
        step = self.step
        rate = np.abs(dq) / np.maximum(step, LEAST)
        return step * np.interp(rate, self._rates, self._gain)
