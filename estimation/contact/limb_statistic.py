"""How many standard deviations the wrench of every sub-tree is away from nothing."""

import numpy as np

from estimation.contact.contact_rows import ContactRows
from estimation.contact.row_covariance import RowCovariance

Array = np.ndarray


class LimbStatistic:
    """Norm of each sub-tree's external wrench, weighted by its covariance.

    Each wrench is looked at in the axes of the sensor through which it enters: there its
    covariance hardly changes while other limbs move. Supports, which nobody judges, have
    the norm of their wrench.
    """

    def __init__(self, rows: ContactRows):
        self._rows = rows
        incidence = rows.layout.incidence
        self._inlets = rows.layout.inlets[np.argmax(incidence > 0.0, axis=1)]

    def update(self, covariance: RowCovariance) -> None:
        """Take the covariance at the present posture."""
        turn = covariance.jacobian[self._inlets]
        matrices = turn @ covariance.of_wrenches() @ turn.transpose(0, 2, 1)
        # a support's own wrench has no error left, and is judged by its reason alone
        matrices[self._rows.removed.subtrees] = np.eye(6)
        self._information = np.linalg.inv(matrices)

    def evaluate(self, touches: Array) -> tuple[Array, Array]:
        """Return statistics (…, s) and forces (…, s) [N] of rows at this posture, (…, nv)."""
        wrenches = self._rows.wrenches(touches)
        local = np.matvec(self._rows.jacobian.take(self._inlets, axis=0), wrenches)
        squares = np.vecdot(local, np.matvec(self._information, local))
        force = wrenches[..., :3]
        return np.sqrt(squares), np.sqrt(np.vecdot(force, force))
