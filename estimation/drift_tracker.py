"""Slow drift of force/torque sensors, followed only while others say that nothing touches.

A sub-graph without contact gives equations without unknowns: the model predicts the reading
of its sensor, and what the sensor reads otherwise is its offset. A sustained push looks the
same to that sensor; so whether something touches is told from outside.
"""

from dataclasses import dataclass

import numpy as np

from estimation.oriented_graph import OrientedGraph

Array = np.ndarray


@dataclass(frozen=True)
class DriftLimits:
    """What is slow and small enough to be drift. Force in N, moment in N m."""

    time_constant: float = 20.0  # s
    force_rate: float = 0.01  # N/s, of any component
    moment_rate: float = 3e-4  # N m/s
    force_gate: float = 1.5  # N; a residual beyond it is no drift
    moment_gate: float = 0.1  # N m
    largest_force: float = 5.0  # N, all that is learnt since the tare
    largest_moment: float = 0.2  # N m
    settle: float = 2.0  # s of calm before anything is learnt

    def scales(self, force: float, moment: float) -> Array:
        """Return a limit per component, (6,)."""
        return np.repeat([force, moment], 3)


class DriftTracker:
    """Follows the offsets of sensors beyond which nothing touches, at a bounded rate.

    A sensor can be followed when no sub-tree on its side away from the inertial sensor
    bears a support or is touched: standing, the arms'; on the pole, all. A push that stays
    below the gate and that nobody reports is learnt, at the bounded rate and up to the
    largest drift.

    Args:
        graph: The observer's graph.
        supports: Sub-trees that bear the robot.
        limits: Rates and sizes.
    """

    def __init__(self, graph: OrientedGraph, supports: set[int], limits: DriftLimits):
        self.drift = np.zeros((len(graph.robot.ft_sensors), 6))  # since the start, N and N m
        self._limits = limits
        # what enters through a sensor is the sum of the sub-trees beyond it
        self._beyond = np.abs(np.linalg.inv(graph.incidence))[1:] > 0.5
        self._bearing = self._beyond[:, sorted(supports)].any(axis=1)
        self._calm = np.zeros(len(self.drift))  # s, of each sensor
        self._stamp: int | None = None

    @property
    def followed(self) -> Array:
        """Which sensors are being followed now, (k,) bool."""
        return self._calm >= self._limits.settle

    def update(self, residual: Array, untouched: Array, valid: Array, stamp: int) -> None:
        """Take one sample.

        Args:
            residual: Predicted minus measured readings, (k, 6), offsets and drift taken off.
            untouched: Sub-trees that somebody else knows to be untouched, (s,) bool. All
                false, for want of evidence, freezes everything.
            valid: Sensors whose residual is valid, (k,) bool.
            stamp: Time of the sample [ns]; one that jumps back starts anew.
        """
        period = 0.0 if self._stamp is None else (stamp - self._stamp) * 1e-9
        self._stamp = stamp
        if not 0.0 <= period <= self._limits.settle:
            self._calm[:] = 0.0
            return
        c = self._limits
        small = (np.abs(residual) <= c.scales(c.force_gate, c.moment_gate)).all(axis=1)
        touched = (self._beyond & ~untouched).any(axis=1)
        calm = valid & small & ~touched & ~self._bearing
        self._calm = np.where(calm, self._calm + period, 0.0)
        self._learn(residual, period)

    def _learn(self, residual: Array, period: float) -> None:
        c = self._limits
        fastest = period * c.scales(c.force_rate, c.moment_rate)
        step = np.clip(-residual * (period / c.time_constant), -fastest, fastest)
        largest = c.scales(c.largest_force, c.largest_moment)
        drift = np.clip(self.drift + step, -largest, largest)
        self.drift = np.where(self.followed[:, None], drift, self.drift)
