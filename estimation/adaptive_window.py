"""The adaptive window: as many samples as a line or a parabola can explain.

After Janabi-Sharifi, Hayward and Chen, "Discrete-time adaptive windowing for
velocity estimation", IEEE Trans. Control Systems Technology 8 (2000), which
Fumagalli uses with fits of first and second order (section 4.3.2): a window grows
from its shortest as long as every sample in it lies within the encoder's
resolution of the fitted polynomial, so that it is long at rest, where
quantisation is all there is, and short in fast motion, which a long one would
smear.

Their window ends at the newest sample, and its fit describes the past by an age
that changes with the window and from channel to channel: half of it for a line.
Here the window grows on both sides of one instant, ``delay`` ago. The fit is read
at its centre, where an even window has no phase error at all; so the delay is the
same for all channels and all windows, and its price is half of the longest one.
"""

from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from estimation.differentiation import LEAST, Array, Centred

RATIO = 1.4  # of the lengths of windows that are tried; all of them would take three times as long
ROUNDING = 1e-9  # of the bound


@dataclass(frozen=True, eq=False)
class AdaptiveWindow(Centred):
    """Least-squares polynomials on a window that adapts to every channel.

    Within the window that is chosen, all samples lie within ``bound`` of the fit. The
    shortest window is taken when not even that one fits.

    Args:
        period: Time between samples [s].
        delay: Age of the instant that the results describe [s], half of the longest
            window; rounded to whole samples.
        bound: Largest distance of a sample from the fit, one per channel or one for all
            [the channel's unit]: the resolution of an encoder, some standard deviations
            of white noise.
        order: Of the fit that gives value and velocity: 1, with a window of its own, or
            2. Accelerations come from fits of second order.
        shortest: Half of the shortest window [s].
    """

    period: float
    delay: float
    bound: Array | float
    order: int = 2
    shortest: float = 3e-3

    def __post_init__(self) -> None:
        if self.period <= 0.0 or round(self.delay / self.period) < LEAST:
            raise ValueError(
                f"a window needs at least {LEAST} samples on each side, got delay {self.delay} s "
                f"with period {self.period} s"
            )
        if not (np.isfinite(self.bound).all() and np.min(self.bound) > 0.0):
            raise ValueError(f"bound: expected positive numbers, got {self.bound}")
        if self.order not in (1, 2):
            raise ValueError(f"order: expected 1 or 2, got {self.order}")
        object.__setattr__(self, "delay", self.side * self.period)

    @cached_property
    def halves(self) -> Array:
        """Samples on each side in the windows that are tried, rising, (h,)."""
        shortest = min(max(1, round(self.shortest / self.period)), self.side)
        count = 1 + int(np.ceil(np.log(self.side / shortest) / np.log(RATIO)))
        return np.unique(np.round(np.geomspace(shortest, self.side, count)).astype(int))

    def of(self, window: Array) -> Array:
        """Value, first and second derivative at the centre, (3, columns)."""
        even, odd = self._fold(window)
        velocity, acceleration = self._choices(even, odd)
        fits = self._fits
        value = fits.line_value if self.order == 1 else fits.parabola_value
        rows = (value @ even, fits.slope @ odd, fits.curvature @ even)
        choices = (velocity, velocity, acceleration)
        column = np.arange(window.shape[1])
        return np.stack([row[at, column] for row, at in zip(rows, choices, strict=True)])

    def chosen_halves(self, window: Array) -> Array:
        """Samples on each side in the windows for velocity and for acceleration, (2, columns)."""
        return self.halves[np.stack(self._choices(*self._fold(window)))]

    def _fold(self, window: Array) -> tuple[Array, Array]:
        """Return even and odd part about the centre, (side + 1, columns) each."""
        after, before = window[self.side :], window[self.side :: -1]
        return 0.5 * (after + before), 0.5 * (after - before)

    def _choices(self, even: Array, odd: Array) -> tuple[Array, Array]:
        """Index into ``halves`` of the windows for velocity and for acceleration, (columns,)."""
        odd_error = np.abs(odd.T @ self._fits.odd_residual)
        parabola = self._longest(np.abs(even.T @ self._fits.parabola_residual) + odd_error)
        if self.order == 2:
            return parabola, parabola
        return self._longest(np.abs(even.T @ self._fits.line_residual) + odd_error), parabola

    def _longest(self, error: Array) -> Array:
        """Grow every column's window until a sample leaves the bound.

        Args:
            error: (columns, r + 1): for one window after the other, the larger distance
                from the fit of each two samples that are equally far from the centre.
        """
        bound = np.atleast_1d(self.bound)[:, None] * (1.0 + ROUNDING)
        outside = error.reshape(-1, len(bound), error.shape[1]) > bound
        outside[..., -1] = True  # the longest window ends all growth
        return self._fits.before[outside.argmax(axis=-1)].ravel()

    @cached_property
    def _fits(self) -> "_Fits":
        return _fits(self.halves, self.side, self.period)


class _Fits(NamedTuple):
    """What maps the even or odd part of a window to the fits on all windows that are tried.

    Residuals stand one window after the other, r in all, and a column of zeros.
    """

    line_value: Array  # (h, side + 1)
    parabola_value: Array
    slope: Array  # [1/s]
    curvature: Array  # [1/s^2]
    line_residual: Array  # (side + 1, r + 1)
    parabola_residual: Array
    odd_residual: Array
    before: Array  # (r + 1,) index of the last window before each residual


def _fits(halves: Array, side: int, period: float) -> _Fits:
    """Fit 1, t and t^2 on each window; even and odd powers do not see each other."""
    values: list[list[Array]] = []
    residuals: list[list[Array]] = []
    for half in halves:
        x = np.arange(half + 1) / half
        bases = (np.stack([x**0]), np.stack([x**0, x**2]), np.stack([x]))
        line, parabola, odd = fits = [_regression(basis) for basis in bases]
        scale = half * period  # [s]
        rows = (line[0], parabola[0], odd[0] / scale, 2.0 * parabola[1] / scale**2)
        values.append([_padded(row[None], side) for row in rows])
        left = [np.eye(half + 1) - b.T @ fit for b, fit in zip(bases, fits, strict=True)]
        residuals.append([_padded(block, side) for block in left])
    stacked = [np.vstack(blocks) for blocks in zip(*values, strict=True)]
    stacked += [np.pad(np.vstack(b).T, ((0, 0), (0, 1))) for b in zip(*residuals, strict=True)]
    before = np.repeat(np.arange(len(halves) + 1), [*(halves + 1), 1]) - 1
    return _Fits(*stacked, before=np.maximum(before, 0))


def _regression(basis: Array) -> Array:
    """Return what maps samples to the coefficients of their fit; all but the first count twice."""
    weighted = 2.0 * basis
    weighted[:, 0] = basis[:, 0]
    return np.linalg.solve(weighted @ basis.T, weighted)


def _padded(block: Array, side: int) -> Array:
    return np.pad(block, ((0, 0), (0, side + 1 - block.shape[1])))
