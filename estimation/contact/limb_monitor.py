"""Which limbs are touched: thresholds with hysteresis, two levels."""

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import repeat
from math import tanh
from typing import NamedTuple

import numpy as np

Array = np.ndarray


@dataclass(frozen=True)
class Levels:
    """When a limb counts as touched. Statistics are in standard deviations."""

    contact: float = 6.5  # least threshold; quiet periods and calibrations may raise it
    margin: float = 1.5  # of a threshold over the largest statistic without a touch
    release: float = 0.6  # fraction of the threshold below which a contact ends
    release_time: float = 0.1  # s below it
    collision: float = 40.0  # N, force from which a contact is a collision
    collision_release: float = 0.8  # fraction of it


class LimbFlag(NamedTuple):
    """State of one limb (sub-tree)."""

    limb: str
    state: str  # none, contact, collision
    probability: float  # of being touched
    onset: int  # ns, when the contact began; 0 without one
    force: float  # N, net force of the touches on the limb
    valid: bool
    reason: str
    statistic: float = 0.0  # standard deviations
    threshold: float = 0.0


class LimbMonitor:
    """F eq. (6.3.1), || w_measured - w_model || > eta, for every sub-tree of its own.

    The norm is that of the covariance, so that newtons and newton metres compare; eta is
    at least ``levels.contact`` and is raised by the statistics of a quiet period, and by a
    calibration, which lasts (``calibrated``).
    """

    def __init__(self, limbs: tuple[str, ...], levels: Levels | None = None):
        self.limbs = limbs
        self.levels = levels or Levels()
        self.calibrated = np.zeros(len(limbs))
        self._quiet = np.zeros(len(limbs))
        self._set_thresholds()
        self._states = ["none"] * len(limbs)
        self._onset = [0] * len(limbs)
        self._below = [0] * len(limbs)  # ns, since when the statistic has been low; 0: not

    def reset(self) -> None:
        """Forget all contacts; thresholds stay."""
        self._states = ["none"] * len(self.limbs)
        self._onset = [0] * len(self.limbs)
        self._below = [0] * len(self.limbs)

    @property
    def touched(self) -> list[int]:
        """Indices of the limbs in contact or collision."""
        return [i for i, state in enumerate(self._states) if state != "none"]

    def learn(self, quiet: Array) -> None:
        """Set thresholds from the largest statistics of a quiet period, (s,)."""
        self._quiet = quiet
        self._set_thresholds()

    def calibrate(self, threshold: Array) -> None:
        """Keep thresholds at least at those of a calibration, (s,)."""
        self.calibrated = threshold
        self._set_thresholds()

    def configure(self, levels: Levels) -> None:
        """Take other levels; contacts stay."""
        self.levels = levels
        self._set_thresholds()

    def _set_thresholds(self) -> None:
        learnt = np.maximum(self.levels.margin * self._quiet, self.calibrated)
        self.threshold = np.maximum(self.levels.contact, learnt)
        self._eta: list[float] = self.threshold.tolist()

    def update(
        self, statistic: Sequence[float], force: Sequence[float], stamp: int, reasons: list[str]
    ) -> list[LimbFlag]:
        """Judge one sample.

        Args:
            statistic: Norm of each limb's wrench in standard deviations, (s,).
            force: Norm of its force, (s,) N.
            stamp: Time of the sample [ns].
            reasons: Why a limb cannot be judged, "" if it can.
        """
        values = zip(statistic, self._eta, force, reasons, strict=True)
        for i, (value, eta, norm, reason) in enumerate(values):
            if reason:
                self._states[i], self._onset[i], self._below[i] = "none", 0, 0
            elif value > eta or self._states[i] != "none":
                self._judge(i, value, eta, norm, stamp)
        return self._flags(statistic, force, reasons)

    def _flags(
        self, statistic: Sequence[float], force: Sequence[float], reasons: list[str]
    ) -> list[LimbFlag]:
        odds, eta = map(contact_probability, statistic, self._eta), self._eta
        columns = self.limbs, self._states, odds, self._onset, force
        flags = [*map(LimbFlag._make, zip(*columns, repeat(True), repeat(""), statistic, eta))]
        for i, reason in enumerate(reasons):
            if reason:
                flags[i] = LimbFlag(self.limbs[i], "none", 0.0, 0, 0.0, False, reason)
        return flags

    def _judge(self, i: int, value: float, eta: float, force: float, stamp: int) -> None:
        levels = self.levels
        if self._states[i] == "none":
            self._states[i], self._onset[i], self._below[i] = "contact", stamp, 0
        elif value >= levels.release * eta:
            self._below[i] = 0
        elif not self._below[i]:
            self._below[i] = stamp
        elif stamp - self._below[i] >= levels.release_time * 1e9:
            self._states[i], self._onset[i] = "none", 0
            return
        factor = levels.collision_release if self._states[i] == "collision" else 1.0
        hard = force >= factor * levels.collision
        self._states[i] = "collision" if hard else "contact"


def contact_probability(statistic: float, threshold: float) -> float:
    """Probability of a touch: even odds at the threshold, by the chi-square likelihood ratio."""
    # the logistic function of half the difference of squares, which never overflows
    return 0.5 + 0.5 * tanh(0.25 * (statistic * statistic - threshold * threshold))
