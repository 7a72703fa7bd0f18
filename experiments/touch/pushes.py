"""Seeded pushes at random places of a robot's surface."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from robot_model import Robot
from robot_model.surface import Surface
from robot_sim import PlantConfig
from robot_sim.pushes import PushShape
from robot_sim.standing import GRAVITY, standing_base

Array = np.ndarray
CONE = np.deg2rad(30.0)  # largest angle between a push and the inward normal
REACH = 0.008  # m, how far from a stored point a place is drawn
FORCES = 5.0, 40.0  # N
KINDS = ("ramp", "tap", "press")
ODDS = (0.45, 0.3, 0.25)
HOLD = 0.7  # s at full force, of ramps and presses
HIDDEN = -1  # sub-tree of the points that are not pushed
STEADY = 0.05  # m, how far a push may move the centre of pressure of a standing robot


@dataclass(frozen=True, eq=False)
class TouchPush:
    """A push: point [m] and largest force [N] in the frame of the link."""

    link: str
    point: Array  # (3,)
    force: Array  # (3,)
    kind: str  # of KINDS
    shape: PushShape

    @property
    def size(self) -> float:
        return float(np.linalg.norm(self.force))

    @property
    def length(self) -> float:
        """Seconds until it is released, or over."""
        return self.shape.duration if self.kind == "tap" else self.shape.rise + HOLD

    @property
    def noticeable(self) -> float:
        """Seconds until the force passes 5 N, or half its peak when that is less."""
        share = min(5.0 / self.size, 0.5)
        if self.kind == "tap":
            return float(np.arcsin(share)) / np.pi * self.shape.duration
        return share * self.shape.rise


class PushGenerator:
    """Draws pushes on what can be touched and seen.

    Those are the ``touchable_links`` of the description, or all links that have a surface.
    Every sub-tree is equally likely, and within it every exposed square centimetre.
    Left out are the sub-trees of the supports, below whose sensors nothing is seen:
    the feet of a standing robot, the root of one on a pole; and the feet there too.
    """

    def __init__(self, robot: Robot):
        self._robot = robot
        self._surface = robot.load_surface()
        owner = np.array([robot.subtree_of(body.name) for body in self._surface.bodies])
        owner[~self._touchable()] = HIDDEN
        self._owner = owner[self._surface.body]
        self._homes = _home_placements(robot)
        self._bearing = STEADY * GRAVITY * robot.mass  # N m

    def _touchable(self) -> Array:
        """Which bodies of the surface are pushed, (b,) bool."""
        robot, names = self._robot, [body.name for body in self._surface.bodies]
        chosen = {robot.frame(link)[0] for link in robot.touchable_links or names}
        return np.array([name in chosen for name in names], dtype=bool)

    def subtrees(self, base: str) -> list[int]:
        """Indices of the sub-trees that are pushed."""
        supports = ("floor",) if base == "free" else ("floor", "pole")
        hidden = {
            self._robot.subtree_of(frame)
            for support in supports
            for frame in self._robot.supports.get(support, ())
        } | {HIDDEN}
        return [i for i in np.unique(self._owner).tolist() if i not in hidden]

    def draw(self, random: np.random.Generator, subtree: int, base: str) -> TouchPush:
        """Draw place, direction, force and course of a push on a sub-tree."""
        index = int(random.choice(np.flatnonzero(self._owner == subtree)))
        point, normal = place_near(self._surface, index, random)
        across = np.cross(normal, random.normal(size=3))
        across /= np.linalg.norm(across)
        angle = CONE * np.sqrt(random.uniform())
        direction = -np.cos(angle) * normal + np.sin(angle) * across
        force = float(np.exp(random.uniform(*np.log(FORCES)))) * direction
        kind = str(random.choice(KINDS, p=ODDS))
        link = self._surface.link_of(index)
        if base == "free":
            force *= self._steady(link, point, force)
        return TouchPush(link, point, force, kind, _shape(kind, random))

    def _steady(self, link: str, point: Array, force: Array) -> float:
        """Factor on a force that would tip the robot over; the force stays above the least."""
        place = self._homes[link]
        moment = np.cross(place.act(point), place.rotation @ force)  # about the soles' middle
        factor = min(1.0, self._bearing / (float(np.linalg.norm(moment[:2])) + 1e-9))
        return max(factor, FORCES[0] / float(np.linalg.norm(force)))


def _shape(kind: str, random: np.random.Generator) -> PushShape:
    if kind == "tap":
        return PushShape("half_sine", random.uniform(0.08, 0.2))
    rise = random.uniform(0.02, 0.3) if kind == "ramp" else random.uniform(0.5, 2.0)
    return PushShape("ramp", rise=rise)


def _home_placements(robot: Robot) -> dict[str, pin.SE3]:
    """Placements of the links of the standing robot; the origin is between the soles."""
    tree = robot.tree
    data = tree.model.createData()
    base = standing_base(robot, PlantConfig().floor)
    pin.framesForwardKinematics(tree.model, data, tree.configuration(robot.home, base))
    return {link: data.oMf[tree.frame_id(link)].copy() for link in robot.links}


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
