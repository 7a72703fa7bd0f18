"""First-order momentum observers, discretised exactly."""

import numpy as np

Array = np.ndarray


class MomentumFilter:
    """Estimates what drives a momentum beyond its known rate, low-passed.

    With p the momentum, b its known rate and f the unknown rest, dp/dt = b + f, the
    residual obeys dr/dt = K (f - r), which is the derivative of R eqs. (7), (11) and (16).
    Between two samples f is taken as its mean, (p1 - p0)/h - (b0 + b1)/2, and the
    filter is then solved exactly: r1 = exp(-K h) r0 + (1 - exp(-K h)) f. It is stable
    for every gain and step, starts at zero whatever the momentum is, and changes its
    gain without a jump.

    Args:
        size: Number of channels.
        gain: Gain of every channel, scalar or (size,) 1/s.
    """

    def __init__(self, size: int, gain: float | Array):
        self._rows = np.zeros((6, size))  # momentum and rate before; those now, mean force
        self.residual = self._rows[5]
        self._step = 0.0  # [s] for which weights and decay were computed
        self._started = False
        self.gain = gain

    @property
    def gain(self) -> Array:
        """Gains, (size,) 1/s."""
        return self._gain

    @gain.setter
    def gain(self, value: float | Array) -> None:
        gain = np.broadcast_to(np.asarray(value, dtype=float), self.residual.shape).copy()
        if not np.all(gain > 0.0):
            raise ValueError(f"residual gains must be positive, got {value}")
        self._gain = gain
        self._step = 0.0

    def reset(self) -> None:
        """Forget the momentum; the residual starts again from zero."""
        self.residual[:] = 0.0
        self._started = False

    def step(
        self, momentum: Array, rate: Array, period: float, force: Array | float = 0.0
    ) -> Array:
        """Take momentum and known rate, (size,), ``period`` seconds after the last ones.

        ``force`` is a part of the known rate of which the mean over the step is known.
        Returns the residual, (size,), in the unit of the rate; overwritten by the next call.
        """
        terms = np.zeros((3, len(self.residual)))
        terms[0], terms[1], terms[2] = momentum, rate, force
        return self.step_terms(terms, period)

    def step_terms(self, terms: Array, period: float) -> Array:
        """The same; ``terms`` (3, size) are momentum, known rate, and the mean force."""
        if self._started:
            self._rows[2:5] = terms
            self._advance(period)
            self._rows[:2] = self._rows[2:4]
        else:
            self.rebase(terms)
        return self.residual

    def rebase(self, terms: Array) -> None:
        """Replace the last sample by one seen from another frame; the residual stays."""
        self._rows[:2] = terms[:2]
        self._started = True

    def _advance(self, period: float) -> None:
        if period != self._step:
            self._step = period
            self._weights = np.array([-1.0 / period, -0.5, 1.0 / period, -0.5, -1.0, -1.0])
            self._blend = -np.expm1(-self._gain * period)
        change = self._weights.dot(self._rows)
        change *= self._blend
        self.residual += change
