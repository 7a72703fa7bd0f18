"""The line of the contact force, cut with the surface; joint torques choose among the cuts."""

from itertools import accumulate, pairwise

import numpy as np

from estimation.contact.limb_touch import LimbTouch
from estimation.contact.link_fits import LinkFits, Places
from estimation.contact.point_forces import SKEW, entry_cost
from estimation.contact.surface_points import Anchors, SurfacePoints

Array = np.ndarray
MISS = 0.006  # m from the line at which a stored point, 10 mm from the next, still is a cut
GRAZING = 0.2  # least cosine between line and normal at which the tangent plane is cut
REACH = 0.01  # m, how far from its stored point a cut with the tangent plane may lie


class ContactLine:
    """The baseline of R section VI.

    The net wrench of the limb gives force and line, eqs. (19) and (22). Where the line
    enters the surface, or comes nearest to it, are the candidates. The torques that the
    wrench would cause in the joints before each link, beside those that are seen, decide
    the link; on one link all candidates cause the same. Errors of the rows are taken as
    independent, as the paper has no covariance.
    """

    def __init__(self, surface: SurfacePoints):
        self._surface = surface

    def forget(self, subtree: int) -> None:
        """Nothing is remembered."""

    def fit(self, touch: LimbTouch) -> LinkFits:
        """Return the best cut on every link of the limb."""
        links = touch.names(touch.bodies)
        sizes = [len(self._surface.points[link]) for link in links]
        starts = [0, *accumulate(sizes)]
        wrench = touch.rows.wrenches(touch.values)[touch.subtree]
        lines = np.linalg.solve(touch.rows.link_maps(touch.bodies), wrench)
        anchors = self._surface.all_of(links)
        value = _near_line(np.repeat(lines, sizes, axis=0), anchors)
        torques = _torque_misfit(touch, wrench)
        best = [i + int(value[i:j].argmax()) for i, j in pairwise(starts)]
        weight = value[best] - torques
        return LinkFits(
            links=links,
            weight=weight,
            point=_cut(lines, Anchors(anchors.point[best], anchors.normal[best])),
            force=lines[:, :3],
            covariance=_covariance(touch, lines),
            misfit=float(-weight.max()),
            places=lambda: Places(links, sizes, anchors.point, value - np.repeat(torques, sizes)),
        )


def _line_point(wrench: Array) -> Array:
    """Return the point of each line, eq. (22), that is nearest to the origin, (k, 3)."""
    force = wrench[:, :3]
    return np.cross(force, wrench[:, 3:]) / _square(force)[:, None]


def _square(force: Array) -> Array:
    return np.vecdot(force, force) + 1e-12


def _near_line(wrench: Array, anchors: Anchors) -> Array:
    """How well each stored point lies on its line, as a log-likelihood, (P,)."""
    force = wrench[:, :3]
    across = np.cross(anchors.point - _line_point(wrench), force)
    distance = np.vecdot(across, across) / _square(force)
    return -0.5 * distance / MISS**2 - entry_cost(force.T, anchors.normal.T)


def _torque_misfit(touch: LimbTouch, wrench: Array) -> Array:
    """Minus the log-likelihood of the joint rows, were the wrench on each body, (b,)."""
    rows = touch.rows
    joints = np.intersect1d(rows.layout.tree.joint_v, touch.covariance.active)
    expected = rows.layout.bears[touch.bodies][:, joints] * (rows.jacobian[joints] @ wrench)
    variance = touch.covariance.matrix.diagonal()[joints]
    return 0.5 * np.square(touch.values[joints] - expected) @ (1.0 / variance)


def _cut(wrench: Array, anchors: Anchors) -> Array:
    """Cut each line with the tangent plane of a stored point, (k, 3); not far from that point."""
    length = np.sqrt(_square(wrench[:, :3]))
    direction = wrench[:, :3] / length[:, None]
    start, (point, normal) = _line_point(wrench), anchors
    along = np.vecdot(point - start, direction)
    steep = np.vecdot(direction, normal)
    foot = start + along[:, None] * direction
    further = np.vecdot(point - foot, normal) / np.where(abs(steep) > GRAZING, steep, np.inf)
    shift = foot + further[:, None] * direction - point
    return point + shift * np.minimum(1.0, REACH / (np.linalg.norm(shift, axis=1) + 1e-12))[:, None]


def _covariance(touch: LimbTouch, wrench: Array) -> Array:
    """Covariance of [point, force] from that of the net wrench, (b, 6, 6)."""
    # the point moves with the lever (f x m) / f^2, and within what a cut may miss
    back = np.linalg.inv(touch.rows.link_maps(touch.bodies))
    seen = touch.rows.wrench_map([touch.subtree])[0]
    of_wrench = back @ (seen @ touch.covariance.matrix @ seen.T) @ back.transpose(0, 2, 1)
    force = wrench[:, :3]
    lever = np.tensordot(force, SKEW, 1) / _square(force)[:, None, None]
    covariance = np.zeros((len(force), 6, 6))
    covariance[:, :3, :3] = lever @ of_wrench[:, 3:, 3:] @ lever.transpose(0, 2, 1)
    covariance[:, :3, :3] += MISS**2 * np.eye(3)
    covariance[:, 3:, 3:] = of_wrench[:, :3, :3]
    return covariance
