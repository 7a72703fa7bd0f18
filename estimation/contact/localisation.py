"""From the rows of a touch to a ranked list of where it may be."""

from dataclasses import dataclass

import numpy as np

from estimation.contact.body_evidence import body_evidence
from estimation.contact.contact_rows import ContactRows
from estimation.contact.row_covariance import RowCovariance
from estimation.contact.surface_likelihood import HOPELESS, PointFits, SurfaceLikelihood

Array = np.ndarray
ALIKE = 1.5  # difference of log-probability that the data do not decide
NOWHERE_COST = 14.0  # log-probability of a wrench that no point explains


@dataclass(frozen=True, eq=False)
class Hypothesis:
    """One place where the robot may be touched.

    ``links``: the link itself, then those that explain the data as well; the rest is in
    the frame of the first link: point [m], force on the robot [N], covariance of both.
    """

    links: tuple[str, ...]
    point: Array  # (3,)
    force: Array  # (3,)
    covariance: Array  # (6, 6)
    probability: float


@dataclass(frozen=True, eq=False)
class Localisation:
    """Hypotheses, best first, and the probability that none of them is right."""

    hypotheses: tuple[Hypothesis, ...]
    none_probability: float


NOWHERE = Localisation((), 1.0)


class Localiser:
    """Finds the point that one touch in a sub-tree pushes at.

    Source: R section VI cuts the line of the external residual (22) with the surface
    and ranks the candidates by the internal residual. Here the likelihood of every
    surface point is computed from base, joint and force/torque rows at once: the line, the
    sub-tree and the joint torques are all in it, weighted by their covariance.
    """

    def __init__(self, rows: ContactRows, most: int = 5):
        self.surface = SurfaceLikelihood(rows.robot)
        self._rows = rows
        self._most = most
        self._bodies = [self._touchable(subtree) for subtree in rows.layout.subtrees]

    def _touchable(self, subtree: int) -> Array:
        """Indices of the links of a sub-tree that have a surface."""
        exposed = [link in self.surface.points for link in self._rows.robot.links]
        return np.flatnonzero((self._rows.layout.subtree == subtree) & exposed)

    def locate(self, touch: Array, covariance: RowCovariance, subtree: int) -> Localisation:
        """Locate one touch.

        Args:
            touch: Rows of the touch at the posture of the ``ContactRows``, (nv,).
            covariance: Their covariance.
            subtree: Index of the sub-tree that is touched.
        """
        rows, bodies = self._rows, self._bodies[subtree]
        if not len(bodies):
            return NOWHERE
        evidence = body_evidence(rows.layout.bears[bodies], rows.jacobian, covariance, touch)
        gains = 0.5 * evidence.gain
        best = gains.max()
        kept = np.flatnonzero(gains > best - HOPELESS)
        names = [rows.robot.links[i] for i in bodies[kept]]
        local = evidence.seen_by(kept, rows.link_maps(bodies[kept]))
        return self._ranked(names, self.surface.fit(names, local), float(best))

    def _ranked(self, names: list[str], fits: PointFits, best: float) -> Localisation:
        weights = np.append(fits.log_likelihood + fits.spread, best - NOWHERE_COST)
        probability = np.exp(weights - weights.max())
        probability /= probability.sum()
        order = np.argsort(-weights[:-1])[: self._most].tolist()
        hypotheses = []
        for i in order:
            alike = [names[j] for j in order if j != i and abs(weights[j] - weights[i]) < ALIKE]
            hypotheses.append(
                Hypothesis(
                    links=(names[i], *alike),
                    point=fits.point[i],
                    force=fits.force[i],
                    covariance=fits.covariance[i],
                    probability=float(probability[i]),
                )
            )
        return Localisation(tuple(hypotheses), float(probability[-1]))
