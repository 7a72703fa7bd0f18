"""Sole corners on a flat floor: spring, damper and bristle friction, all feet at once."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin
from pydantic import BaseModel, ConfigDict, Field
from robot_model import Robot

Array = np.ndarray


class Floor(BaseModel):
    """Floor at z = 0, as one sole corner feels it; the values stand at a 1 ms tick."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    stiffness: float = Field(4e4, gt=0)  # N/m; 8e4 and more hop
    damping: float = Field(80.0, ge=0)  # N s/m; 150 chatters
    tangential_stiffness: float = Field(2e4, gt=0)  # N/m
    tangential_damping: float = Field(60.0, ge=0)  # N s/m
    friction: float = Field(0.8, ge=0)  # 1, Coulomb cone


class Placement(NamedTuple):
    """A frame seen from the joint that carries it in one tree."""

    joint: int
    joint_M_frame: pin.SE3


def placement(model: pin.Model, frame_id: int) -> Placement:
    """Return the joint that carries a frame, and where the frame is on it."""
    frame = model.frames[frame_id]
    return Placement(frame.parentJoint, frame.placement)


def point_velocity_map(points: Array) -> Array:
    """Return the matrix (3p, 6) from a twist [v w] to the velocities of points (p, 3).

    Its transpose maps the forces at the points to their wrench [f m].
    """
    rows = [np.hstack([np.eye(3), -pin.skew(point)]) for point in points]
    return np.vstack(rows)


class SoleContacts:
    """Contact forces of all soles.

    Args:
        robot: Gives the soles' frames and corners.
        data: Pinocchio data of ``robot.tree``; its placements and velocities must be
            up to date when ``evaluate`` is called.
        cut: The tree cut at the F/T sensors, whose foot bodies lie below the sensors.
        floor: Contact parameters.

    Attributes:
        frames: Names of the soles, (F,).
        wrench: (F, 6) per sole, on the joint that carries it in ``robot.tree``.
        wrench_cut: (F, 6) the same on the joint of the cut tree.
        wrench_sole: (F, 6) the same in the sole frame.
    """

    def __init__(self, robot: Robot, data: pin.Data, cut, floor: Floor):
        self.frames = tuple(robot.supports["floor"])
        tree = robot.tree
        whole = [placement(tree.model, tree.frame_id(name)) for name in self.frames]
        parts = [placement(cut.model, cut.frame_id(name)) for name in self.frames]
        self.joints = [place.joint for place in whole]
        self.joints_cut = [place.joint for place in parts]
        corners = [np.asarray(robot.soles[name]) for name in self.frames]
        self._floor = floor
        self._corners = np.array(
            [[w.joint_M_frame.act(c) for c in cs] for w, cs in zip(whole, corners, strict=True)]
        )
        self._velocity = np.array([point_velocity_map(points) for points in self._corners])
        self._wrenches = np.array(
            [_wrench_map(w, p, cs) for w, p, cs in zip(whole, parts, corners, strict=True)]
        )
        self._views = [
            (data.oMi[j].rotation, data.oMi[j].translation, data.v[j].vector) for j in self.joints
        ]
        count = len(self.frames)
        self._rotation = np.zeros((count, 3, 3))
        self._position = np.zeros((count, 1, 3))
        self._twist = np.zeros((count, 6, 1))
        self._all = np.zeros((count, 18))
        self.wrench, self.wrench_cut, self.wrench_sole = np.split(self._all, 3, axis=1)
        self._anchor = np.zeros((count, self._corners.shape[1], 2))

    def restart(self) -> None:
        """Forget the bristles: they start unstretched where the corners are now."""
        position, _ = self._corner_motion()
        self._anchor = position[..., :2].copy()

    def release(self) -> None:
        """Set all contact forces to zero."""
        self._all[:] = 0.0

    def evaluate(self) -> None:
        """Compute the wrenches of the present state and move the bristles that slip."""
        position, velocity = self._corner_motion()
        force = self._force(position, velocity) @ self._rotation
        flat = force.reshape(len(self.frames), -1, 1)
        np.matmul(self._wrenches, flat, out=self._all[:, :, None])

    def _corner_motion(self) -> tuple[Array, Array]:
        for i, (rotation, translation, twist) in enumerate(self._views):
            self._rotation[i] = rotation
            self._position[i, 0] = translation
            self._twist[i, :, 0] = twist
        to_world = self._rotation.transpose(0, 2, 1)
        position = self._corners @ to_world
        position += self._position
        velocity = (self._velocity @ self._twist).reshape(self._corners.shape) @ to_world
        return position, velocity

    def _force(self, position: Array, velocity: Array) -> Array:
        floor = self._floor
        height, sinking = position[..., 2], velocity[..., 2]
        normal = np.maximum(-floor.stiffness * height - floor.damping * sinking, 0.0)
        normal *= height < 0.0  # the damper never pulls a lifted corner back
        drag = floor.tangential_damping * velocity[..., :2]
        friction = floor.tangential_stiffness * (self._anchor - position[..., :2]) - drag
        size = np.sqrt(np.square(friction).sum(axis=2))
        limit = floor.friction * normal
        slips = size > limit
        if slips.any():
            friction[slips] *= (limit[slips] / size[slips])[:, None]
            stretch = (friction[slips] + drag[slips]) / floor.tangential_stiffness
            self._anchor[slips] = position[slips, :2] + stretch
        force = np.empty_like(position)
        force[..., :2] = friction
        force[..., 2] = normal
        return force


def _wrench_map(whole: Placement, part: Placement, corners: Array) -> Array:
    """Return (18, 12): corner forces in the whole tree's joint axes to the three wrenches."""
    targets = (whole.joint_M_frame, part.joint_M_frame, pin.SE3.Identity())
    rows = []
    for target_M_sole in targets:
        points = np.array([target_M_sole.act(corner) for corner in corners])
        turn = target_M_sole.rotation @ whole.joint_M_frame.rotation.T
        rows.append(point_velocity_map(points).T @ np.kron(np.eye(len(corners)), turn))
    return np.vstack(rows)
