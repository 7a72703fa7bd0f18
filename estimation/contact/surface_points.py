"""Exposed points of every body, as the search for a touch needs them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from estimation.contact.point_forces import monomials
from robot_model import Robot

Array = np.ndarray


class Anchors(NamedTuple):
    """Stored points of the surface and their outward normals, (k, 3) each."""

    point: Array
    normal: Array


class SurfacePoints:
    """Exposed points about 10 mm apart, by link and in its frame.

    Attributes:
        points: (P, 3) m, by link; links without a surface are left out.
        normals: (P, 3) outward.
        powers: (10, P) ``monomials`` of the points.
        normal_rows: (3, P) the normals once more, for products with many forces.
    """

    def __init__(self, robot: Robot):
        surface = robot.load_surface()
        self.points: dict[str, Array] = {}
        self.normals: dict[str, Array] = {}
        for index, body in enumerate(surface.bodies):
            mine = surface.body == index
            if mine.any():
                self.points[body.name] = surface.points[mine]
                self.normals[body.name] = surface.normals[mine]
        self.powers = {link: monomials(points) for link, points in self.points.items()}
        self.normal_rows = {link: normals.T.copy() for link, normals in self.normals.items()}

    def touchable(self, robot: Robot, subtree: int) -> Array:
        """Indices of the links of a sub-tree that have a surface."""
        mine = [link in self.points and robot.subtree_of(link) == subtree for link in robot.links]
        return np.flatnonzero(mine)

    def all_of(self, links: Sequence[str]) -> Anchors:
        """Return all points of some links, one link after the other."""
        points = [self.points[link] for link in links]
        return Anchors(np.concatenate(points), np.concatenate([self.normals[x] for x in links]))

    def anchors(self, links: Sequence[str], index: Sequence[int]) -> Anchors:
        """Return one point of each link."""
        pairs = list(zip(links, index, strict=True))
        return Anchors(
            np.array([self.points[link][i] for link, i in pairs]),
            np.array([self.normals[link][i] for link, i in pairs]),
        )

    def square_distance(self, link: str, index: int) -> Array:
        """Return the squared distances [m^2] of a link's points from one of them, (P,)."""
        return _away_from(self.points[link][index]) @ self.powers[link]

    def nearest(self, links: Sequence[str], point: Array) -> Anchors:
        """Return the stored point nearest to one place (k, 3) on each link."""
        away = _away_from(point)
        pairs = zip(away, links, strict=True)
        return self.anchors(links, [int((w @ self.powers[x]).argmin()) for w, x in pairs])


def _away_from(point: Array) -> Array:
    """Return |x - p|^2 as weights of the monomials of x, (..., 10), of places p (..., 3)."""
    weights = np.zeros((*point.shape[:-1], 10))
    weights[..., 0] = np.vecdot(point, point)
    weights[..., 1:4] = -2.0 * point
    weights[..., [4, 7, 9]] = 1.0
    return weights
