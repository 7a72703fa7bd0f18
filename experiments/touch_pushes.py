"""Seeded pushes at random places of a robot's surface."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from robot_model import Robot
from robot_model.surface import Surface

Array = np.ndarray
CONE = np.deg2rad(30.0)  # largest angle between a push and the inward normal
REACH = 0.008  # m, how far from a stored point a place is drawn
PLACES = ("surface", "links")


@dataclass(frozen=True, eq=False)
class TouchPush:
    """A push: point [m] and force [N] in the frame of the link."""

    link: str
    point: Array  # (3,)
    force: Array  # (3,)


class PushGenerator:
    """Draws pushes on every sub-tree in turn, but for those below the supports' sensors.

    With places ``surface`` every exposed square centimetre of a sub-tree is equally
    likely; with ``links`` every link is, however small.
    """

    def __init__(self, robot: Robot, seed: int, force: float = 15.0, places: str = "surface"):
        if places not in PLACES:
            raise ValueError(f"places must be one of {', '.join(PLACES)}, got '{places}'")
        self._surface = robot.load_surface()
        self._random = np.random.default_rng(seed)
        self._force = force
        self._by_link = places == "links"
        feet = {robot.subtree_of(frame) for frame in robot.supports["floor"]}
        owner = np.array([robot.subtree_of(body.name) for body in self._surface.bodies])
        self._subtrees = [i for i in range(len(robot.subtrees)) if i not in feet]
        self._points = {i: np.flatnonzero(owner[self._surface.body] == i) for i in self._subtrees}

    def __iter__(self) -> Iterator[TouchPush]:
        while True:
            for subtree in self._random.permutation(self._subtrees):
                yield self._draw(self._points[subtree])

    def _draw(self, candidates: Array) -> TouchPush:
        surface, random = self._surface, self._random
        if self._by_link:
            body = random.choice(np.unique(surface.body[candidates]))
            candidates = candidates[surface.body[candidates] == body]
        index = int(random.choice(candidates))
        point, normal = place_near(surface, index, random)
        across = np.cross(normal, random.normal(size=3))
        across /= np.linalg.norm(across)
        angle = CONE * np.sqrt(random.uniform())
        direction = -np.cos(angle) * normal + np.sin(angle) * across
        return TouchPush(surface.link_of(index), point, self._force * direction)


def place_near(surface: Surface, index: int, random: np.random.Generator) -> tuple[Array, Array]:
    """Draw a place on the mesh near a stored point, so that the estimator's own points are
    no better known than any other; returns point [m] and outward normal."""
    anchor, normal = surface.points[index], surface.normals[index]
    body = surface.bodies[surface.body[index]]
    corners = body.vertices[body.triangles]  # (T, 3, 3)
    near = np.linalg.norm(corners.mean(axis=1) - anchor, axis=1) < REACH
    corners = corners[near]
    spans = np.cross(corners[:, 1] - corners[:, 0], corners[:, 2] - corners[:, 0])
    areas = np.linalg.norm(spans, axis=1)
    along = spans @ normal
    facing = np.abs(along) > 0.8 * areas
    if not (areas * facing).sum() > 0.0:
        return anchor, normal
    chosen = random.choice(len(areas), p=areas * facing / (areas * facing).sum())
    weights = random.dirichlet(np.ones(3))
    return weights @ corners[chosen], spans[chosen] * np.sign(along[chosen]) / areas[chosen]
