"""Where on the robot's surface a pure force explains the rows of a touch best."""

from itertools import accumulate
from typing import NamedTuple

import numpy as np

from estimation.contact.body_evidence import BodyEvidence
from estimation.contact.limb_touch import HOPELESS, LimbTouch
from estimation.contact.link_fits import LinkFits, Places
from estimation.contact.point_forces import SKEW, entry_cost, normal_equations, point_forces
from estimation.contact.surface_points import SurfacePoints

Array = np.ndarray
REACH = 0.007  # m about a stored point that the surface surely has: half a diagonal of the grid
SHIFT = 0.006  # m beyond that, one sigma
STRIDE = 0.03  # m, of one step within it, one sigma
DEPTH = 0.002  # m, how well the surface's depth is known, one sigma
EXTENT = 0.1  # m, how far a touch may lie from where it is found at all, one sigma
APART = 0.025  # m between two places on a link that are refined each for itself,
STEPS = 4  # of the refinement
TWICE = 6  # on so many links, the best ones
_HOLDING = np.eye(6, k=3)  # slope of [f, x cross f] by [x, f], where it is constant, and
_TURNING = np.zeros((6, 6, 6))  # where it follows x or f, to be flattened behind them
_TURNING[:3, 3:, 3:], _TURNING[3:, 3:, :3] = SKEW, -SKEW
_TURNING = _TURNING.reshape(6, 36)


class _Tried(NamedTuple):
    """All stored points of some links, one link after the other."""

    value: list[Array]  # log-likelihood of the points of each link, (P_i,)
    force: list[Array]  # (3, P_i) N, the best at each


class Refined(NamedTuple):
    """Touches moved within the surface to where their likelihood is largest."""

    value: Array  # (k,) log-likelihood, with what its normal costs
    touch: Array  # (k, 6) [point, force]
    covariance: Array  # (k, 6, 6)


class SurfaceLikelihood:
    """Tries a touch at every exposed point of the touched limb.

    A touch is a pure force at a point of the surface, pressing inwards. For every point
    the best force has a closed form, so that all points are simply tried.

    Source: R section VI cuts the line of the external residual (22) with the surface
    and ranks the candidates by the internal residual. Here the likelihood of every
    surface point is computed from base, joint and force/torque rows at once: the line, the
    sub-tree and the joint torques are all in it, weighted by their covariance.
    """

    def __init__(self, surface: SurfacePoints):
        self._surface = surface

    def forget(self, subtree: int) -> None:
        """Nothing is remembered."""

    def fit(self, touch: LimbTouch) -> LinkFits:
        """Return the best touch on every hopeful link."""
        links = touch.links
        tried = self._tried(links, touch.local)
        value, best, covariance = self._refined(links, tried, touch.local)
        return LinkFits(
            links=links,
            weight=value + _spread(tried),
            point=best[:, :3],
            force=best[:, 3:],
            covariance=covariance,
            misfit=float(touch.free_gain.max() - value.max()),
            places=lambda: self._places(links, tried),
        )

    def _tried(self, links: list[str], evidence: BodyEvidence) -> _Tried:
        surface = self._surface
        forms = normal_equations(*evidence)
        powers = [surface.powers[link] for link in links]
        equations = [form @ power for form, power in zip(forms, powers, strict=True)]
        force, gain = point_forces(np.concatenate(equations, axis=1))
        normals = np.concatenate([surface.normal_rows[link] for link in links], axis=1)
        value = 0.5 * gain - entry_cost(force, normals)
        ends = list(accumulate(power.shape[1] for power in powers))[:-1]
        return _Tried(np.split(value, ends), np.split(force, ends, axis=1))

    def _refined(self, links: list[str], tried: _Tried, evidence: BodyEvidence) -> "Refined":
        """Refine the best place of every link, of the best links the best two.

        A line enters a link more than once, and which stored point lies nearer to it is
        chance.
        """
        k, first = len(links), [int(part.argmax()) for part in tried.value]
        again = np.argsort([-part.max() for part in tried.value])[:TWICE]
        second = [self._elsewhere(links[i], tried.value[i], first[i]) for i in again]
        owner, index = [*range(k), *again.tolist()], [*first, *second]
        names = [links[i] for i in owner]
        forces = [tried.force[i][:, point] for i, point in zip(owner, index, strict=True)]
        start = np.hstack((self._surface.anchors(names, index).point, forces))
        refined = refine(self._surface, names, start, BodyEvidence(*(x[owner] for x in evidence)))
        chosen, other = np.arange(k), k + np.arange(len(again))
        chosen[again] = np.where(refined.value[other] > refined.value[again], other, again)
        return Refined(*(part[chosen] for part in refined))

    def _elsewhere(self, link: str, value: Array, best: int) -> int:
        """Index of the best point of a link that is not near the best one."""
        distance = self._surface.square_distance(link, best)
        return int(np.where(distance > APART**2, value, -np.inf).argmax())

    def _places(self, links: list[str], tried: _Tried) -> Places:
        weight = np.concatenate(tried.value)
        count = [len(part) for part in tried.value]
        return Places(links, count, self._surface.all_of(links).point, weight)


def _spread(tried: _Tried) -> Array:
    """Log of the number of points of each link that are about as good as its best, (k,)."""
    # the exponential of what is hopeless is slow
    behind = [np.maximum(part - part.max(), -HOPELESS) for part in tried.value]
    return np.log([np.exp(part).sum() for part in behind])


def refine(
    surface: SurfacePoints, links: list[str], touch: Array, evidence: BodyEvidence
) -> Refined:
    """Move touches within the surface to where the likelihood is largest.

    Stored points are 10 mm apart; an exact sensor tells more than that. Near a stored point
    the surface is equally likely everywhere: a light push, whose line is little known, is not
    drawn to the point.

    Args:
        surface: The stored points.
        links: k links, a name may come more than once.
        touch: [point, force] on each link, (k, 6), changed in place.
        evidence: For a wrench on each link, in its frame.
    """
    information, score = evidence
    point, force = touch[:, :3], touch[:, 3:]
    for _ in range(STEPS):
        anchor, normal = surface.entered(links, point, force)
        point -= normal * np.vecdot(normal, point - anchor)[:, None]  # onto the tangent plane
        beyond = _beyond(point - anchor)
        prior = _shift_information(normal, np.where(beyond.any(axis=1), SHIFT, STRIDE))
        slope = _wrench_slope(touch)
        curvature = slope.transpose(0, 2, 1) @ information @ slope
        curvature[:, :3, :3] += prior
        missing = score - np.matvec(information, np.matvec(slope[:, :, 3:], force))
        descent = np.vecmat(missing, slope)
        descent[:, :3] -= np.matvec(prior, beyond)
        touch += np.linalg.solve(curvature, descent[:, :, None])[:, :, 0]
    wrench, shift = np.matvec(_wrench_slope(touch)[:, :, 3:], force), point - anchor
    value = np.vecdot(wrench, score - 0.5 * np.matvec(information, wrench))
    outside = _shift_information(normal, np.full(len(normal), SHIFT))
    beyond = _beyond(shift)
    value -= 0.5 * np.vecdot(beyond, np.matvec(outside, beyond))
    value -= entry_cost(force.T, surface.entered(links, point, force).normal.T)
    curvature[:, :3, :3] -= prior  # which only held the search on the surface
    curvature[:, :3, :3] += _shift_information(normal, np.full(len(normal), EXTENT))
    return Refined(value, touch, np.linalg.inv(curvature))


def _beyond(shift: Array) -> Array:
    """What is left of shifts from a stored point, (k, 3), after ``REACH``."""
    length = np.linalg.norm(shift, axis=1, keepdims=True)
    return shift * np.maximum(0.0, 1.0 - REACH / np.maximum(length, REACH))


def _wrench_slope(touch: Array) -> Array:
    """Return the slope of the wrench [f, x cross f] by [x, f], (k, 6, 6)."""
    return (touch @ _TURNING).reshape(-1, 6, 6) + _HOLDING


def _shift_information(normal: Array, shift: Array) -> Array:
    """Return the inverse covariance of touches within the surface, (k, 3, 3); shift (k,) m."""
    within = 1.0 / np.square(shift)[:, None, None]
    across = normal[:, :, None] * normal[:, None]
    return across * (1.0 / DEPTH**2 - within) + within * np.eye(3)
