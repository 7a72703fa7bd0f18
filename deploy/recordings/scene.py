"""The robot and what pushes it, for Foxglove's 3D panel."""

from collections.abc import Iterator
from typing import Any

import numpy as np
import pinocchio as pin

from dashboard.forces import Force, estimated_forces
from dashboard.placement import Placement
from dashboard.touches import touches
from deploy.recordings.scene_entities import (
    BLUE,
    ORANGE,
    RED,
    arrow,
    entity,
    robot_entities,
    transform,
)
from deploy.recordings.selection import Item
from robot_model import Robot, ports

RATE = 50.0  # Hz, of poses and arrows
WORLD = "world"
LIFETIME = 200_000_000  # ns after which an arrow that is not renewed disappears
TOUCH, SUPPORT = 0.01, 0.001  # m/N
HIDE_BELOW = 1.0  # N
TOPICS = {  # and the Foxglove schema of each
    "transforms": "foxglove.FrameTransforms",
    "static_transforms": "foxglove.FrameTransforms",
    "robot": "foxglove.SceneUpdate",
    "forces": "foxglove.SceneUpdate",
}

Update = tuple[str, int, dict[str, Any]]  # topic, time [ns], message


class Scene:
    """Follows one robot's estimated state; truth is never drawn.

    Without an estimated base the base link stands at the world's origin.
    """

    def __init__(self, robot: Robot):
        self._robot = robot
        self._names = {ports.name(key, robot): key for key in ("base", "wrenches", "contacts")}
        self._sensors = ports.name("sensors", robot)
        self._newest: dict[str, Any] = {}
        self._placement = Placement(robot)
        self._parents = self._placement.parents(robot.links)
        self._due: int | None = None

    def topic(self, name: str) -> str:
        """Return the name of one of the scene's topics."""
        return f"/{self._robot.name}/3d/{name}"

    def updates(self, item: Item, time: int) -> Iterator[Update]:
        """Take one message, and yield what is to be drawn at ``time`` [ns]."""
        name, envelope = item.port.name, item.envelope
        if (key := self._names.get(name)) is not None:
            self._newest[key] = item.message if envelope.valid else None
        if name != self._sensors or not envelope.valid or envelope.model != self._robot.model_hash:
            return
        if self._due is None:
            yield from self._once(time)
        if self._due is None or time >= self._due:
            self._due = time + round(1e9 / RATE)
            yield from self._now(item.message.q, time)

    def _once(self, time: int) -> Iterator[Update]:
        """What never changes: the robot's shape, and URDF frames on their bodies."""
        fixed = [
            transform(time, body.name, frame, pin.SE3ToXYZQUAT(placement))
            for body in self._robot.bodies.values()
            for frame, placement in body.placements.items()
            if frame != body.name
        ]
        yield self.topic("static_transforms"), time, {"transforms": fixed}
        entities = robot_entities(time, self._robot)
        yield self.topic("robot"), time, {"deletions": [], "entities": entities}

    def _now(self, q: np.ndarray, time: int) -> Iterator[Update]:
        base = self._newest.get("base")
        where = (base.position, base.quat_wxyz) if base else (np.zeros(3), np.eye(4)[0])
        self._placement.update(q, *where)
        links = self._robot.links
        poses = self._placement.poses(links, self._parents)
        above = [WORLD if parent < 0 else links[parent] for parent in self._parents]
        moved = [transform(time, *row) for row in zip(above, links, poses, strict=True)]
        yield self.topic("transforms"), time, {"transforms": moved}
        arrows = {"wrenches": self._wrenches(), "touch": self._touch()}
        drawn = [entity(time, WORLD, k, LIFETIME, arrows=v) for k, v in arrows.items()]
        yield self.topic("forces"), time, {"deletions": [], "entities": drawn}

    def _wrenches(self) -> list[dict[str, Any]]:
        wrenches = self._newest.get("wrenches")
        found = estimated_forces(wrenches, self._placement) if wrenches else []
        return [
            arrow(force, SUPPORT if force.support else TOUCH, BLUE if force.support else ORANGE)
            for force in found
            if np.linalg.norm(force.force) >= HIDE_BELOW
        ]

    def _touch(self) -> list[dict[str, Any]]:
        contacts = self._newest.get("contacts")
        best = touches(contacts, self._placement)[:1] if contacts else []
        return [arrow(Force(touch.point, touch.force, False), TOUCH, RED) for touch in best]
