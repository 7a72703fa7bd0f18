"""Constant errors of what is measured, each in the axes of its own sensor."""

from dataclasses import dataclass

import numpy as np

from estimation.contact.row_layout import RowLayout

Array = np.ndarray


@dataclass(frozen=True)
class BiasPrior:
    """Standard deviations of what is constant before a tare."""

    base_force: float = 1.0  # N, the accelerometer's bias times the mass
    base_moment: float = 0.3  # N m
    torque: float = 0.3  # N m
    ft_force: float = 1.0  # N
    ft_moment: float = 0.03  # N m


class RowBias:
    """Biases of the rows before the supports' wrenches are taken from them.

    A support hides its own sensor's bias: a tare sees only what removing the support makes
    of all biases together, r = P b at the posture of the tare. The biases are then the
    likeliest ones, and what stays open of them is felt again when the posture changes.

    Attributes:
        value: (nv,) biases b.
        covariance: (nv, nv) of what is open of them; P covariance P^T is zero where the
            tare was made.
    """

    def __init__(self, layout: RowLayout, prior: BiasPrior | None = None):
        prior, tree, nv = prior or BiasPrior(), layout.tree, layout.model.nv
        deviation = np.zeros(nv)
        deviation[:3], deviation[3:6] = prior.base_force, prior.base_moment
        deviation[tree.joint_v] = prior.torque
        deviation[tree.cut_v] = np.repeat([prior.ft_force, prior.ft_moment], 3)
        self._prior = np.square(deviation)
        self.value, self.covariance = np.zeros(nv), np.zeros((nv, nv))
        self.reset()

    def reset(self) -> None:
        """Know nothing; the covariance counts from the first tare on."""
        self.value[:], self.covariance[:] = 0.0, 0.0
        self._gain = np.zeros_like(self.covariance)

    def tare(self, rows: Array, removal: Array, active: Array) -> None:
        """Explain the rows of an untouched robot.

        Args:
            rows: (nv,) with all biases in them, supports removed.
            removal: P, (nv, nv), at this posture.
            active: (nv,) bool, rows that say something.
        """
        seen = removal[active] * self._prior  # P C
        gain = np.linalg.solve(seen @ removal[active].T, seen).T
        self._gain[:, active] = gain
        self._gain[:, ~active] = 0.0
        self.value[:] = self._gain @ rows
        self.covariance[:] = np.diag(self._prior) - gain @ seen

    def follow(self, rows: Array, share: float) -> None:
        """Take a share of what the rows, (nv,), show beyond the biases as a drift of these."""
        self.value += self._gain @ (share * rows)
