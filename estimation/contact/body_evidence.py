"""What the rows of a touch say of a wrench on each of some bodies."""

from typing import NamedTuple

import numpy as np

from estimation.contact.row_covariance import RowCovariance

Array = np.ndarray


class BodyEvidence(NamedTuple):
    """-2 log L = (F - F0)^T N (F - F0) + const for a wrench F on each of b bodies."""

    information: Array  # N, (b, 6, 6), of [f m] in the root's axes
    score: Array  # N F0, (b, 6)

    @property
    def gain(self) -> Array:
        """Drop of -2 log L that a free wrench on each body brings (D of a chi-square test)."""
        wrench = np.linalg.solve(self.information, self.score[:, :, None])[:, :, 0]
        return np.vecdot(self.score, wrench)

    def seen_by(self, bodies: Array, maps: Array) -> "BodyEvidence":
        """Return the evidence of some of the bodies, in frames of their own.

        Args:
            bodies: (k,) indices.
            maps: (k, 6, 6) of wrenches from those frames into the root's.
        """
        turned = maps.transpose(0, 2, 1)
        return BodyEvidence(
            turned @ self.information[bodies] @ maps, np.matvec(turned, self.score[bodies])
        )


def body_evidence(
    bears: Array, jacobian: Array, covariance: RowCovariance, touch: Array
) -> BodyEvidence:
    """Return the evidence for a wrench on each body.

    Args:
        bears: (b, nv) bool, rows in which a wrench on each body appears.
        jacobian: (nv, 6), see ``ContactRows``.
        covariance: Of the rows.
        touch: (nv,) rows of the touch.
    """
    bodies, nv = bears.shape
    vectors = np.empty((6 * bodies + 1, nv))
    np.multiply(bears[:, None], jacobian.T, out=vectors[:-1].reshape(bodies, 6, nv))
    vectors[-1] = touch
    white = covariance.whiten(vectors)
    columns, rows = white[:-1].reshape(bodies, 6, -1), white[-1]
    return BodyEvidence(columns @ columns.transpose(0, 2, 1), columns @ rows)
