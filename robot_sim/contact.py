"""Sole corners on a flat floor: spring, damper and bristle friction, all feet at once."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin
from pydantic import BaseModel, ConfigDict, Field

from robot_model import Robot, TreeModel
from robot_sim.body import ExternalForces
from robot_sim.joint_rows import joint_rows

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
        joints, joints_cut = [p.joint for p in whole], [p.joint for p in parts]
        corners = [robot.soles[name] for name in self.frames]
        local = [[w.joint_M_frame.act(c) for c in cs] for w, cs in zip(whole, corners, strict=True)]
        maps = [_wrench_map(w, p, cs) for w, p, cs in zip(whole, parts, corners, strict=True)]
        # One product for all feet is cheaper than one per foot, zeros included.
        self._wrench_map = _block_diagonal(np.array(maps))
        self._point_map = _point_map(np.array(local))
        self._rows = np.array(joints)
        self._placements, self._twists = joint_rows(data.oMi), joint_rows(data.v)
        self._allocate(*np.shape(local)[:2])
        self._set_floor(floor, *np.shape(local)[:2])
        rows = joints, self.wrench, joints_cut, self.wrench_cut
        self._loads = list(zip(*rows, strict=True))

    def _set_floor(self, floor: Floor, feet: int, size: int) -> None:
        self._friction = floor.friction
        self._cone = np.array([1.0, 1.0, -(floor.friction**2)])
        stiffness = [floor.tangential_stiffness, floor.tangential_stiffness, floor.stiffness]
        damping = [floor.tangential_damping, floor.tangential_damping, floor.damping]
        gains = np.repeat(np.column_stack([stiffness, damping]), size, axis=1)
        self._gains = -np.broadcast_to(gains, (feet, 3, 2 * size))

    def _allocate(self, feet: int, size: int) -> None:
        # Axis before corner, so that every component is one contiguous row.
        shape = (feet, 3, size)
        self._twist = np.ones(6 * feet + 1)  # of all feet, and the 1 that adds a constant
        self._foot_twist = self._twist[:-1].reshape(feet, 6)
        self._place = np.zeros((feet, 12))
        self._world_to_joint = self._place.reshape(feet, 4, 3)[:, :3]
        self._joint_to_world = self._place.reshape(feet, 4, 3).transpose(0, 2, 1)  # [R p]
        self._points = np.zeros((feet, 4, 2 * size))  # corners [p 1], then velocities [v 0]
        self._motion = np.zeros((feet, 3, 2 * size))  # the same in the world, times the gains
        self._spring, self._drag = self._motion[:, :, :size], self._motion[:, :, size:]
        self._pull = np.zeros(shape)  # N, of the bristles' anchors; z stays 0, on the floor
        self._force, self._force_local = np.zeros(shape), np.zeros(shape)
        self._wrenches = np.zeros((feet, 18))
        self.wrench, self.wrench_cut, self.wrench_sole = np.split(self._wrenches, 3, axis=1)
        # Flat views for the products that serve all feet at once.
        self._flat_points, self._flat_force = (
            self._points.reshape(-1),
            self._force_local.reshape(-1),
        )
        self._flat_wrenches = self._wrenches.reshape(-1)

    def restart(self) -> None:
        """Forget the bristles: they start unstretched where the corners are now."""
        self._move_corners()
        self._pull[:, :2] = -self._spring[:, :2]

    def release(self) -> None:
        """Set all contact forces to zero."""
        self._wrenches[:] = 0.0

    def evaluate(self) -> None:
        """Compute the wrenches of the present state and move the bristles that slip."""
        self._move_corners()
        self._find_forces()
        np.matmul(self._world_to_joint, self._force, out=self._force_local)
        self._wrench_map.dot(self._flat_force, out=self._flat_wrenches)

    def add_to(self, whole: ExternalForces, cut: ExternalForces) -> None:
        """Add the wrenches to the forces on the robot's tree and on the cut tree."""
        for joint, wrench, joint_cut, wrench_cut in self._loads:
            whole.add(joint, wrench)
            cut.add(joint_cut, wrench_cut)

    def _move_corners(self) -> None:
        """Find the forces of springs and dampers, but for the springs' anchors."""
        # Any other mode would go through a buffer.
        self._twists.take(self._rows, 0, self._foot_twist, "clip")
        self._placements.take(self._rows, 0, self._place, "clip")
        self._point_map.dot(self._twist, out=self._flat_points)
        np.matmul(self._joint_to_world, self._points, out=self._motion)
        np.multiply(self._motion, self._gains, out=self._motion)

    def _find_forces(self) -> None:
        force = np.add(self._pull, self._spring, out=self._force)
        force += self._drag
        normal = force[:, 2]
        np.maximum(normal, 0.0, out=normal)
        # The damper never pulls a lifted corner back.
        normal *= np.heaviside(self._spring[:, 2], 0.0)
        slips = self._cone @ (force * force) > 0.0
        foot, corner = slips.nonzero()
        if foot.size:
            self._slip(foot, corner)

    def _slip(self, foot: Array, corner: Array) -> None:
        """Cut friction at the Coulomb cone and drag the bristles along."""
        friction = self._force[foot, :2, corner]
        limit = self._friction * self._force[foot, 2, corner]
        friction *= (limit / np.linalg.norm(friction, axis=1))[:, None]
        self._force[foot, :2, corner] = friction
        rest = self._spring[foot, :2, corner] + self._drag[foot, :2, corner]
        self._pull[foot, :2, corner] = friction - rest


def _by_axis(rows: Array) -> Array:
    """Reorder rows from corner by corner (x y z x y z ...) to axis by axis."""
    return rows.reshape(-1, 3, rows.shape[1]).transpose(1, 0, 2).reshape(rows.shape)


def _block_diagonal(blocks: Array) -> Array:
    """Return (F r, F c): the blocks (F, r, c), each in rows and columns of its own."""
    count, rows, columns = blocks.shape
    placed = np.einsum("fg,frc->frgc", np.eye(count), blocks)
    return placed.reshape(count * rows, count * columns)


def _point_map(corners: Array) -> Array:
    """Return the map from the feet's twists and a 1 to corners [p 1] and velocities [v 0].

    Corners (F, c, 3) in joint axes; the map is (F * 4 * 2 c, 6 F + 1), corners before
    velocities in a row, so that one [R p] per foot takes both to the world.
    """
    feet, size, _ = corners.shape
    points = np.zeros((feet, 4, 2 * size, 6 * feet + 1))
    points[:, :3, :size, -1] = corners.transpose(0, 2, 1)
    points[:, 3, :size, -1] = 1.0
    velocity = _block_diagonal(np.array([_by_axis(point_velocity_map(foot)) for foot in corners]))
    points[:, :3, size:, :-1] = velocity.reshape(feet, 3, size, -1)
    return points.reshape(-1, 6 * feet + 1)


def _wrench_map(whole: Placement, part: Placement, corners: Array) -> Array:
    """Return (18, 12): corner forces in the whole tree's joint axes to the three wrenches."""
    targets = (whole.joint_M_frame, part.joint_M_frame, pin.SE3.Identity())
    rows = []
    for target_M_sole in targets:
        points = np.array([target_M_sole.act(corner) for corner in corners])
        turn = target_M_sole.rotation @ whole.joint_M_frame.rotation.T
        rows.append(point_velocity_map(points).T @ np.kron(np.eye(len(corners)), turn))
    return _by_axis(np.vstack(rows).T).T
