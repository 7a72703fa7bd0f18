"""One touch on one limb: its rows, and what they say of a wrench on each of its bodies."""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from estimation.contact.body_evidence import BodyEvidence, body_evidence
from estimation.contact.contact_rows import ContactRows
from estimation.contact.row_covariance import RowCovariance

Array = np.ndarray
HOPELESS = 40.0  # log-likelihood behind the best at which nothing is tried or counted


@dataclass(frozen=True, eq=False)
class LimbTouch:
    """What a way to find the place is given.

    Attributes:
        rows: At the posture of the sample.
        values: (nv,) rows of this touch alone; supports and other touches are removed.
        covariance: Of those rows.
        subtree: Index of the sub-tree that is touched.
        bodies: (b,) indices in ``robot.links`` of its bodies that have a surface, b >= 1.
    """

    rows: ContactRows
    values: Array
    covariance: RowCovariance
    subtree: int
    bodies: Array

    @cached_property
    def evidence(self) -> BodyEvidence:
        """For a wrench on each of the bodies, in the root's axes."""
        bears = self.rows.layout.bears[self.bodies]
        return body_evidence(bears, self.rows.jacobian, self.covariance, self.values)

    @cached_property
    def free_gain(self) -> Array:
        """Log-likelihood that a free wrench on each body gains, (b,)."""
        return 0.5 * self.evidence.gain

    @cached_property
    def hopeful(self) -> Array:
        """Indices in ``bodies`` of those where a touch is not out of the question, (k,)."""
        return np.flatnonzero(self.free_gain > self.free_gain.max() - HOPELESS)

    @cached_property
    def links(self) -> list[str]:
        """Names of the hopeful bodies."""
        return self.names(self.bodies[self.hopeful])

    @cached_property
    def local(self) -> BodyEvidence:
        """Evidence for the hopeful bodies, in their own frames."""
        return self.evidence.seen_by(self.hopeful, self.rows.link_maps(self.bodies[self.hopeful]))

    def names(self, bodies: Sequence[int] | Array) -> list[str]:
        """Return the names of some links."""
        return [self.rows.robot.links[i] for i in bodies]
