"""Sole corners on a flat floor: spring, damper and bristle friction, all feet at once."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin
from pydantic import BaseModel, ConfigDict, Field
from scipy.linalg import block_diag

from robot_model import Robot, TreeModel

Array = np.ndarray


class Floor(BaseModel):
    """Floor at z = 0, as one sole corner feels it; the values stand at a 1 ms tick."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    stiffness: float = Field(default=4e4, gt=0)  # N/m; 8e4 and more hop
    damping: float = Field(default=80.0, ge=0)  # N s/m; 150 chatters
    tangential_stiffness: float = Field(default=2e4, gt=0)  # N/m
    tangential_damping: float = Field(default=60.0, ge=0)  # N s/m
    friction: float = Field(default=0.8, ge=0)  # 1, Coulomb cone


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


class Foot(NamedTuple):
    """One foot's share of the arrays, and views of its joint's motion."""

    rotation: Array  # (3, 3) R_world_joint
    origin: Array  # (3, 1) of the joint, world
    joint_twist: Array  # (6,) joint axes
    twist: Array  # (6,) copy of it in the stack of all feet
    corners: Array  # (3, c) joint axes
    velocity_local: Array  # (3, c) joint axes
    position: Array  # (3, c) world
    velocity: Array  # (3, c) world
    force: Array  # (3, c) world
    force_local: Array  # (3, c) joint axes


def stands_on(robot: Robot) -> tuple[str, ...]:
    """Return the soles of a robot that can stand on the floor, nothing for another.

    Raises:
        ValueError: the floor supports differ in their corners, or have less than three.
    """
    frames = tuple(robot.supports.get("floor", ()))
    counts = {name: len(robot.soles.get(name, ())) for name in frames}
    if not any(counts.values()):
        return ()
    if any(count < 3 for count in counts.values()) or len(set(counts.values())) > 1:
        raise ValueError(
            f"{robot.name}: soles: expected as many corners, at least 3, for each floor support, "
            f"got {counts}"
        )
    return frames


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

    def __init__(self, robot: Robot, data: pin.Data, cut: TreeModel, floor: Floor):
        self.frames = tuple(robot.supports["floor"])
        tree = robot.tree
        whole = [placement(tree.model, tree.frame_id(name)) for name in self.frames]
        parts = [placement(cut.model, cut.frame_id(name)) for name in self.frames]
        self.joints = [place.joint for place in whole]
        self.joints_cut = [place.joint for place in parts]
        corners = [robot.soles[name] for name in self.frames]
        local = [[w.joint_M_frame.act(c) for c in cs] for w, cs in zip(whole, corners, strict=True)]
        maps = [_wrench_map(w, p, cs) for w, p, cs in zip(whole, parts, corners, strict=True)]
        # One product for all feet is cheaper than one per foot, zeros included.
        velocity_maps = [_by_axis(point_velocity_map(np.array(cs))) for cs in local]
        self._velocity_map = np.asarray(block_diag(*velocity_maps))
        self._wrench_map = np.asarray(block_diag(*maps))
        # Axis before corner, so that every component is one contiguous row.
        self._corners = np.ascontiguousarray(np.transpose(local, (0, 2, 1)))
        self._set_floor(floor, self._corners.shape)
        self._allocate(data, *self._corners.shape)

    def _set_floor(self, floor: Floor, shape: tuple[int, ...]) -> None:
        self._friction, self._cone = floor.friction, floor.friction**2
        tangential = np.array([1.0, 1.0, 0.0])[:, None]
        stiffness = tangential * floor.tangential_stiffness + (1 - tangential) * floor.stiffness
        damping = tangential * floor.tangential_damping + (1 - tangential) * floor.damping
        self._stiffness = np.broadcast_to(stiffness, shape).copy()
        self._damping = np.broadcast_to(damping, shape).copy()

    def _allocate(self, data: pin.Data, count: int, axes: int, size: int) -> None:
        shape = (count, axes, size)
        self._twist = np.zeros((count, 6))
        self._velocity_local = np.zeros(shape)
        self._position, self._velocity = np.zeros(shape), np.zeros(shape)
        self._force, self._force_local = np.zeros(shape), np.zeros(shape)
        self._anchor = np.zeros(shape)  # of the bristles; z stays 0, on the floor
        self._all = np.zeros((count, 18))
        self.wrench, self.wrench_cut, self.wrench_sole = np.split(self._all, 3, axis=1)
        self._feet = [
            Foot(
                rotation=data.oMi[joint].rotation,
                origin=data.oMi[joint].translation[:, None],
                joint_twist=data.v[joint].vector,
                twist=self._twist[i],
                corners=self._corners[i],
                velocity_local=self._velocity_local[i],
                position=self._position[i],
                velocity=self._velocity[i],
                force=self._force[i],
                force_local=self._force_local[i],
            )
            for i, joint in enumerate(self.joints)
        ]
        # Flat views for the products that serve all feet at once.
        self._twists, self._velocities = self._twist.reshape(-1), self._velocity_local.reshape(-1)
        self._forces, self._wrenches = self._force_local.reshape(-1), self._all.reshape(-1)

    def restart(self) -> None:
        """Forget the bristles: they start unstretched where the corners are now."""
        self._move_corners()
        self._anchor[:, :2] = self._position[:, :2]

    def release(self) -> None:
        """Set all contact forces to zero."""
        self._all[:] = 0.0

    def evaluate(self) -> None:
        """Compute the wrenches of the present state and move the bristles that slip."""
        self._move_corners()
        self._find_forces()
        for foot in self._feet:
            np.dot(foot.rotation.T, foot.force, out=foot.force_local)
        np.dot(self._wrench_map, self._forces, out=self._wrenches)

    def _move_corners(self) -> None:
        for foot in self._feet:
            foot.twist[:] = foot.joint_twist
        np.dot(self._velocity_map, self._twists, out=self._velocities)
        for foot in self._feet:
            np.dot(foot.rotation, foot.corners, out=foot.position)
            np.add(foot.position, foot.origin, out=foot.position)
            np.dot(foot.rotation, foot.velocity_local, out=foot.velocity)

    def _find_forces(self) -> None:
        drag = self._velocity * self._damping
        force = np.subtract(self._anchor, self._position, out=self._force)
        force *= self._stiffness
        force -= drag
        normal = force[:, 2]
        np.maximum(normal, 0.0, out=normal)
        normal *= self._position[:, 2] < 0.0  # the damper never pulls a lifted corner back
        square = force * force
        slips = square[:, 0] + square[:, 1] > self._cone * square[:, 2]
        if np.count_nonzero(slips):
            self._slip(slips, drag)

    def _slip(self, slips: Array, drag: Array) -> None:
        """Cut friction at the Coulomb cone and drag the bristles along."""
        foot, corner = np.nonzero(slips)
        friction = self._force[foot, :2, corner]
        limit = self._friction * self._force[foot, 2, corner]
        friction *= (limit / np.linalg.norm(friction, axis=1))[:, None]
        self._force[foot, :2, corner] = friction
        stretch = (friction + drag[foot, :2, corner]) / self._stiffness[0, 0, 0]
        self._anchor[foot, :2, corner] = self._position[foot, :2, corner] + stretch


def _by_axis(rows: Array) -> Array:
    """Reorder rows from corner by corner (x y z x y z ...) to axis by axis."""
    return rows.reshape(-1, 3, rows.shape[1]).transpose(1, 0, 2).reshape(rows.shape)


def _wrench_map(whole: Placement, part: Placement, corners: Array) -> Array:
    """Return (18, 12): corner forces in the whole tree's joint axes to the three wrenches."""
    targets = (whole.joint_M_frame, part.joint_M_frame, pin.SE3.Identity())
    rows = []
    for target_M_sole in targets:
        points = np.array([target_M_sole.act(corner) for corner in corners])
        turn = target_M_sole.rotation @ whole.joint_M_frame.rotation.T
        rows.append(point_velocity_map(points).T @ np.kron(np.eye(len(corners)), turn))
    return _by_axis(np.vstack(rows).T).T
