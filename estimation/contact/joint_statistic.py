"""One statistic for the whole body: how much better any touch explains the rows than none."""

from typing import NamedTuple

import numpy as np

from estimation.contact.contact_rows import ContactRows
from estimation.contact.row_covariance import RowCovariance

Array = np.ndarray


class JointValue(NamedTuple):
    """What the whole body shows at one sample."""

    statistic: float  # square root of D, in standard deviations
    force: float  # N, of the touch that explains the rows best
    subtree: int  # in which it is


class JointStatistic:
    """D = max over bodies of g^T N^-1 g, with N = B^T Sigma^-1 B and g = B^T Sigma^-1 e.

    B = J_b^T carries a wrench on body b to the rows e of covariance Sigma, so D is the
    largest generalised likelihood ratio of a wrench anywhere. All rows count, the joints'
    torques too; bodies that the same rows bear are one. Their projections
    chol(N)^-1 B^T Sigma^-1 follow the posture as slowly as the covariance does, and leave
    one product of a matrix and a vector for every sample.
    """

    def __init__(self, rows: ContactRows):
        self._rows = rows
        self._subtrees: tuple[int, ...] | None = None

    def update(self, covariance: RowCovariance) -> None:
        """Take the covariance and the Jacobian of the present posture."""
        self._choose()
        count, nv = self._bears.shape
        carried = (self._bears[:, None] * self._rows.jacobian.T).reshape(6 * count, nv)
        weighted = (carried @ covariance.information()).reshape(count, 6, nv)
        seen = weighted @ carried.reshape(count, 6, nv).transpose(0, 2, 1)
        back = np.linalg.inv(np.linalg.cholesky(seen))
        self._projection = (back @ weighted).reshape(6 * count, nv)
        self._forces = back.transpose(0, 2, 1)[:, :3]

    def evaluate(self, touch: Array) -> JointValue:
        """Return the statistic of the rows of one sample, (nv,), tared."""
        shares = (self._projection @ touch).reshape(-1, 6)
        gains = np.vecdot(shares, shares)
        best = int(gains.argmax())
        force = self._forces[best] @ shares[best]
        return JointValue(
            float(np.sqrt(gains[best])), float(np.sqrt(force @ force)), int(self._subtree[best])
        )

    def of_rows(self, touches: Array) -> Array:
        """Return the statistic of many samples at the same posture, (T, nv) to (T,)."""
        shares = touches @ self._projection.T
        return np.sqrt(np.square(shares).reshape(len(touches), -1, 6).sum(axis=2).max(axis=1))

    def _choose(self) -> None:
        """Bodies outside the supporting sub-trees, those that differ."""
        removed = self._rows.removed
        if self._subtrees == tuple(removed.subtrees):
            return
        self._subtrees, layout = tuple(removed.subtrees), self._rows.layout
        free = np.flatnonzero(~np.isin(layout.subtree, removed.subtrees))
        bears, first = np.unique(layout.bears[free] & removed.active, axis=0, return_index=True)
        self._bears, self._subtree = bears, layout.subtree[free[first]]
