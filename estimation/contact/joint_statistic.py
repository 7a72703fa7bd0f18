"""One statistic for the whole body: how much better any touch explains the rows than none."""

from collections.abc import Iterator
from math import sqrt
from typing import NamedTuple

import numpy as np

from estimation.contact.contact_rows import ContactRows
from estimation.contact.row_covariance import RowCovariance

Array = np.ndarray
PARTS = 2  # in which the bodies are projected


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
        """Take a covariance and the Jacobian of its posture."""
        for _ in self.renewal(covariance):
            pass

    def renewal(self, covariance: RowCovariance) -> Iterator[None]:
        """``update`` in some pieces; the old projections serve until the last one is done."""
        self._choose()
        information = covariance.information()
        columns = covariance.jacobian[self._active].T.copy()
        bodies, rows = self._bears.shape
        projections, forces = np.empty((bodies, 6, rows)), np.empty((bodies, 3, 6))
        for part in np.array_split(np.arange(len(self._bears)), PARTS):
            yield
            projections[part], forces[part] = _project(self._bears[part], columns, information)
        self._projection, self._forces = projections.reshape(-1, rows), forces

    def evaluate(self, touch: Array) -> JointValue:
        """Return the statistic of the rows of one sample, (nv,), tared."""
        shares = self._projection.dot(touch.take(self._active)).reshape(-1, 6)
        gains = np.vecdot(shares, shares)
        best = int(gains.argmax())
        x, y, z = self._forces[best].dot(shares[best]).tolist()
        return JointValue(sqrt(gains[best]), sqrt(x * x + y * y + z * z), int(self._subtree[best]))

    def of_rows(self, touches: Array) -> Array:
        """Return the statistic of many samples at the same posture, (T, nv) to (T,)."""
        shares = (touches[:, self._active] @ self._projection.T).reshape(len(touches), -1, 6)
        return np.sqrt(np.square(shares).sum(axis=2).max(axis=1))

    def _choose(self) -> None:
        """Bodies outside the supporting sub-trees, those that differ."""
        removed = self._rows.removed
        if self._subtrees == tuple(removed.subtrees):
            return
        self._subtrees, layout = tuple(removed.subtrees), self._rows.layout
        self._active = np.flatnonzero(removed.active)
        free = np.flatnonzero(~np.isin(layout.subtree, removed.subtrees))
        bears, first = np.unique(layout.bears[free][:, self._active], axis=0, return_index=True)
        self._bears, self._subtree = bears.astype(float), layout.subtree[free[first]]


def _project(bears: Array, columns: Array, information: Array) -> tuple[Array, Array]:
    """Return projections (b, 6, a) of rows, and the forces (b, 3, 6) that they stand for.

    Args:
        bears: (b, a) 1 where a wrench on each body appears.
        columns: (6, a) Jacobian.
        information: (a, a) inverse covariance.
    """
    carried = bears[:, None] * columns
    weighted = (carried.reshape(-1, len(information)) @ information).reshape(carried.shape)
    back = np.linalg.inv(np.linalg.cholesky(weighted @ carried.transpose(0, 2, 1)))
    return back @ weighted, back.transpose(0, 2, 1)[:, :3]
