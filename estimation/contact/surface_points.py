"""Exposed points of every body, as the search for a touch needs them."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from estimation.contact.point_forces import ENTRY, monomials
from robot_model import Robot

Array = np.ndarray
SPACING = 0.01  # m between the points


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

    def entered(self, links: Sequence[str], point: Array, force: Array) -> Anchors:
        """Return the stored point where a force (k, 3) near a place (k, 3) of each link enters.

        That is the nearest one, but near an edge of the surface the normal of the nearest
        is that of one side by chance: of those around the place that the force enters best.
        """
        inward = -force / (np.linalg.norm(force, axis=1, keepdims=True) + 1e-12)
        triples = zip(links, _away_from(point), inward, strict=True)
        return self.anchors(links, [self._entered(*one) for one in triples])

    def _entered(self, link: str, away: Array, inward: Array) -> int:
        distance, normals = away @ self.powers[link], self.normals[link]
        nearest = int(distance.argmin())
        if normals[nearest] @ inward > ENTRY:
            return nearest
        near = np.flatnonzero(distance <= max(SPACING**2, distance[nearest]))
        return int(near[(normals[near] @ inward).argmax()])


def _away_from(point: Array) -> Array:
    """Return |x - p|^2 as weights of the monomials of x, (..., 10), of places p (..., 3)."""
    weights = np.zeros((*point.shape[:-1], 10))
    weights[..., 0] = np.vecdot(point, point)
    weights[..., 1:4] = -2.0 * point
    weights[..., [4, 7, 9]] = 1.0
    return weights
