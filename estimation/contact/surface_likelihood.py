"""Where on the robot's surface a pure force explains the rows of a touch best."""

from collections.abc import Sequence
from itertools import accumulate, pairwise
from typing import NamedTuple

import numpy as np

from estimation.contact.body_evidence import BodyEvidence
from estimation.contact.point_forces import (
    SKEW,
    entry_cost,
    monomials,
    normal_equations,
    point_forces,
)
from robot_model import Robot

Array = np.ndarray
HOPELESS = 40.0  # log-likelihood behind the best at which nothing is tried or counted
SHIFT = 0.006  # m, how far a touch may lie from the nearest stored point, one sigma
DEPTH = 0.002  # m, how well the surface's depth is known, one sigma
_ALONG = np.eye(3) / SHIFT**2
_HOLDING = np.eye(6, k=3)  # slope of [f, x cross f] by [x, f], where it is constant, and
_TURNING = np.zeros((6, 6, 6))  # where it follows x or f, to be flattened behind them
_TURNING[:3, 3:, 3:], _TURNING[3:, 3:, :3] = SKEW, -SKEW
_TURNING = _TURNING.reshape(6, 36)


class PointFits(NamedTuple):
    """The best touch on each of k bodies, in their frames."""

    log_likelihood: Array  # (k,) of the best point, with what its normal costs
    spread: Array  # (k,) log of the number of points that are about as good
    point: Array  # (k, 3) m
    force: Array  # (k, 3) N
    covariance: Array  # (k, 6, 6) of [point, force]


class SurfaceLikelihood:
    """Exposed points of every body, and the likelihood of a touch at each.

    A touch is a pure force at a point of the surface, pressing inwards. For every point
    the best force has a closed form, so that all points are simply tried.
    """

    def __init__(self, robot: Robot):
        surface = robot.load_surface()
        self.points: dict[str, Array] = {}  # (P, 3) in the link's frame, by link
        self.normals: dict[str, Array] = {}
        for index, body in enumerate(surface.bodies):
            mine = surface.body == index
            if mine.any():
                self.points[body.name] = surface.points[mine]
                self.normals[body.name] = surface.normals[mine]
        self._monomials = {link: monomials(points) for link, points in self.points.items()}
        self._normal_rows = {link: normals.T.copy() for link, normals in self.normals.items()}

    def fit(self, links: Sequence[str], evidence: BodyEvidence) -> PointFits:
        """Return the best touch on each link; the evidence is in the frames of the links."""
        best, force, spread = self._tried(links, evidence)
        touch = np.concatenate((self._anchors(links, best)[0], force), axis=1)
        return self._refined(links, touch, spread, evidence)

    def _tried(
        self, links: Sequence[str], evidence: BodyEvidence
    ) -> tuple[list[int], Array, Array]:
        """Try all points; return the best of each link, its force (k, 3), and the spreads (k,)."""
        forms = normal_equations(*evidence)
        powers = [self._monomials[link] for link in links]
        equations = [form @ power for form, power in zip(forms, powers, strict=True)]
        force, gain = point_forces(np.concatenate(equations, axis=1))
        normals = np.concatenate([self._normal_rows[link] for link in links], axis=1)
        value = 0.5 * gain - entry_cost(force, normals)
        starts = [0, *accumulate(power.shape[1] for power in powers)]
        parts = [value[i:j] for i, j in pairwise(starts)]
        best = [int(part.argmax()) for part in parts]
        behind = [part - part[i] for part, i in zip(parts, best, strict=True)]
        # the exponential of what is hopeless is slow
        spread = [np.exp(np.maximum(part, -HOPELESS)).sum() for part in behind]
        chosen = [start + i for start, i in zip(starts, best, strict=False)]
        return best, force[:, chosen].T, np.log(spread)

    def _anchors(self, links: Sequence[str], index: Sequence[int]) -> tuple[Array, Array]:
        """Return one stored point of each link and its normal, (k, 3) each."""
        pairs = list(zip(links, index, strict=True))
        return (
            np.array([self.points[link][i] for link, i in pairs]),
            np.array([self.normals[link][i] for link, i in pairs]),
        )

    def _nearest(self, links: Sequence[str], point: Array) -> tuple[Array, Array]:
        """Return the stored point nearest to one of each link, and its normal."""
        # |x - p|^2 less what all x share is linear in the monomials of x
        weights = np.tile([0.0, 0, 0, 0, 1, 0, 0, 1, 0, 1], (len(links), 1))
        weights[:, 1:4] = -2.0 * point
        pairs = zip(weights, links, strict=True)
        return self._anchors(links, [int((w @ self._monomials[x]).argmin()) for w, x in pairs])

    def _refined(
        self, links: Sequence[str], touch: Array, spread: Array, evidence: BodyEvidence
    ) -> PointFits:
        """Move the best stored points within the surface to where the likelihood is largest.

        Stored points are 10 mm apart; an exact sensor tells more than that. ``touch`` holds
        [point, force] of each link, (k, 6).
        """
        information, score = evidence
        point, force = touch[:, :3], touch[:, 3:]
        for _ in range(3):
            anchor, normal = self._nearest(links, point)
            point -= normal * np.vecdot(normal, point - anchor)[:, None]  # onto the tangent plane
            prior, slope = _shift_information(normal), _wrench_slope(touch)
            curvature = slope.transpose(0, 2, 1) @ information @ slope
            curvature[:, :3, :3] += prior
            missing = score - np.matvec(information, np.matvec(slope[:, :, 3:], force))
            descent = np.vecmat(missing, slope)
            descent[:, :3] -= np.matvec(prior, point - anchor)
            touch += np.linalg.solve(curvature, descent[:, :, None])[:, :, 0]
        wrench, shift = np.matvec(_wrench_slope(touch)[:, :, 3:], force), point - anchor
        value = np.vecdot(wrench, score - 0.5 * np.matvec(information, wrench))
        value -= 0.5 * np.vecdot(shift, np.matvec(prior, shift)) + entry_cost(force.T, normal.T)
        return PointFits(value, spread, point, force, np.linalg.inv(curvature))


def _wrench_slope(touch: Array) -> Array:
    """Return the slope of the wrench [f, x cross f] by [x, f], (k, 6, 6)."""
    return (touch @ _TURNING).reshape(-1, 6, 6) + _HOLDING


def _shift_information(normal: Array) -> Array:
    """Return the inverse covariance of touches about a stored point, (k, 3, 3)."""
    across = normal[:, :, None] * normal[:, None]
    across *= 1.0 / DEPTH**2 - 1.0 / SHIFT**2
    return across + _ALONG
