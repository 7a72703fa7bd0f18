"""From the rows of a touch to a ranked list of where it may be."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from estimation.contact_rows import ContactRows
from estimation.row_covariance import RowCovariance
from estimation.surface_likelihood import PointFit, SurfaceLikelihood, body_evidence

Array = np.ndarray
HOPELESS = 40.0  # log-likelihood behind the best body at which no point is tried
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

    def locate(self, touch: Array, covariance: RowCovariance, subtree: int) -> Localisation:
        """Locate one touch.

        Args:
            touch: Rows of the touch at the posture of the ``ContactRows``, (nv,).
            covariance: Their covariance.
            subtree: Index of the sub-tree that is touched.
        """
        layout, links = self._rows.layout, self._rows.robot.links
        bodies = [
            i for i in np.flatnonzero(layout.subtree == subtree) if links[i] in self.surface.points
        ]
        evidence = {
            i: body_evidence(layout.bears[i], self._rows.jacobian, covariance.information, touch)
            for i in bodies
        }
        gains = {i: 0.5 * e.gain for i, e in evidence.items()}
        if not gains:
            return NOWHERE
        best = max(gains.values())
        placements = self._rows.place_links()
        kept = [i for i in bodies if gains[i] > best - HOPELESS]
        fits = {links[i]: self.surface.fit(links[i], evidence[i], placements[i]) for i in kept}
        return self._ranked(fits, best, {links[i]: placements[i] for i in kept})

    def _ranked(
        self, fits: dict[str, PointFit], best: float, placements: dict[str, pin.SE3]
    ) -> Localisation:
        names = list(fits)
        weights = np.array([fits[name].log_likelihood + fits[name].spread for name in names])
        weights = np.append(weights, best - NOWHERE_COST)
        probability = np.exp(weights - weights.max())
        probability /= probability.sum()
        order = np.argsort(-weights[:-1])[: self._most]
        hypotheses = []
        for i in order:
            alike = [names[j] for j in order if j != i and abs(weights[j] - weights[i]) < ALIKE]
            hypotheses.append(
                in_link((names[i], *alike), fits[names[i]], placements[names[i]], probability[i])
            )
        return Localisation(tuple(hypotheses), float(probability[-1]))


def in_link(
    links: tuple[str, ...], fit: PointFit, placement: pin.SE3, probability: float
) -> Hypothesis:
    """Express a fit in the frame of its link."""
    turn = placement.rotation.T
    both = np.zeros((6, 6))
    both[:3, :3] = both[3:, 3:] = turn
    return Hypothesis(
        links=links,
        point=turn @ (fit.point - placement.translation),
        force=turn @ fit.force,
        covariance=both @ fit.covariance @ both.T,
        probability=float(probability),
    )
