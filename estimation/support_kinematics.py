"""Where the inertial sensor and the supports are and how they move, seen from the base."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from estimation.rotations import Rows, Vector, add, cross, rotate
from estimation.support_wrenches import SoleBox, sole_box
from robot_model import Robot

BASE = pin.ReferenceFrame.WORLD  # the base stays in the model's origin


class FrameMotion(NamedTuple):
    """Pose and twist of a frame relative to the base link, in the base's frame."""

    rotation: Rows  # R_base_frame
    position: Vector  # m
    linear: Vector  # m/s, of the point that passes through the base's origin
    angular: Vector  # rad/s


class Support(NamedTuple):
    """A loaded support."""

    motion: FrameMotion
    weight: float  # its share of the load; the shares add up to 1
    center: Vector  # m, centre of pressure in the base's frame


class Load(NamedTuple):
    """What a support bears."""

    force: Vector  # N, of the world on the robot, in base axes
    center: Vector  # m, centre of pressure in the base's frame


class SupportKinematics:
    """Forward kinematics of one inertial sensor and of some support frames.

    The load of a support is the reading of the sensor through which its sub-tree hangs;
    the weight below that sensor is neglected. A support in the base's own sub-tree (a
    pole) hangs on no sensor.
    """

    def __init__(self, robot: Robot, supports: tuple[str, ...]):
        self.supports = supports
        self._tree = robot.tree
        self._data = self._tree.model.createData()
        self._q = self._tree.neutral.copy()
        self._v = np.zeros(self._tree.model.nv)
        self._imu = self._tree.frame_id(robot.imus[0])
        self._frames = [self._tree.frame_id(name) for name in supports]
        self._sensor = [robot.subtrees[robot.subtree_of(name)].ft_in for name in supports]
        self._ft_frames = [self._tree.frame_id(name) for name in robot.ft_frames]
        self.soles = [robot.soles.get(name) for name in supports]  # corners, where known
        self._boxes = [sole_box(corners, margin=0.0) for corners in self.soles]
        self._rigid = [self._rigid_pose(i) for i in range(len(supports))]
        self.imu_joints = self._path(self._imu)
        self._joints = [self._path(frame) for frame in self._frames]

    def _path(self, frame: int) -> np.ndarray:
        """Return (n,): which joints lie between the base and a frame."""
        model, joint = self._tree.model, self._tree.model.frames[frame].parentJoint
        path = np.zeros(len(self._tree.joint_v), dtype=bool)
        while joint > 1:
            path |= self._tree.joint_v == model.joints[joint].idx_v
            joint = model.parents[joint]
        return path

    def usable(self, joint_valid: np.ndarray, ft_valid: np.ndarray) -> list[int]:
        """Return the supports whose pose and load can be computed."""
        complete = all(joint_valid.tolist())
        return [
            i
            for i, sensor in enumerate(self._sensor)
            if (complete or joint_valid[self._joints[i]].all()) and (sensor < 0 or ft_valid[sensor])
        ]

    def update(self, q: np.ndarray, dq: np.ndarray) -> None:
        """Take the joints' positions and velocities, (n,) rad and rad/s."""
        tree = self._tree
        self._q[tree.joint_q], self._v[tree.joint_v] = q, dq
        pin.forwardKinematics(tree.model, self._data, self._q, self._v)

    def imu(self) -> FrameMotion:
        """Return the motion of the inertial sensor relative to the base."""
        return self._motion(self._imu)

    def support(self, index: int) -> FrameMotion:
        """Return the motion of a support frame relative to the base."""
        return self._motion(self._frames[index])

    def _motion(self, frame: int) -> FrameMotion:
        model, data = self._tree.model, self._data
        placement = pin.updateFramePlacement(model, data, frame)
        twist = pin.getFrameVelocity(model, data, frame, BASE)
        return FrameMotion(*_pose(placement), twist.linear.tolist(), twist.angular.tolist())

    @property
    def without_sensor(self) -> bool:
        """Whether there are supports and their loads cannot be told from other contacts."""
        return bool(self._sensor) and min(self._sensor) < 0

    def load(self, index: int, motion: FrameMotion, ft: np.ndarray) -> Load:
        """Return what a support with this motion bears, from the readings (k, 6)."""
        rotation, arm = self._rigid[index] or self._support_m_sensor(index)
        reading = ft[self._sensor[index]].tolist()
        force = rotate(rotation, [-f for f in reading[:3]])
        moment = add(cross(arm, force), rotate(rotation, reading[3:]), -1.0)
        center = center_of_pressure(force, moment, self._boxes[index])
        return Load(
            rotate(motion.rotation, force), add(motion.position, rotate(motion.rotation, center))
        )

    def _support_m_sensor(self, index: int) -> tuple[Rows, Vector]:
        model, data = self._tree.model, self._data
        base_m_sensor = pin.updateFramePlacement(model, data, self._ft_frames[self._sensor[index]])
        base_m_support = pin.updateFramePlacement(model, data, self._frames[index])
        return _pose(base_m_support.actInv(base_m_sensor))

    def _rigid_pose(self, index: int) -> tuple[Rows, Vector] | None:
        """Return support_M_sensor where no joint lies between the two; it is constant."""
        if (sensor := self._sensor[index]) < 0:
            return None
        support = self._tree.model.frames[self._frames[index]]
        bearer = self._tree.model.frames[self._ft_frames[sensor]]
        if support.parentJoint != bearer.parentJoint:
            return None
        return _pose(support.placement.actInv(bearer.placement))


def _pose(placement: pin.SE3) -> tuple[Rows, Vector]:
    return placement.rotation.tolist(), placement.translation.tolist()


def center_of_pressure(force: Vector, moment: Vector, box: SoleBox | None) -> Vector:
    """Return the centre of pressure [m] in the plane z = 0 of a support frame.

    Args:
        force, moment: Of the world on the support, in the support frame, z upwards.
        box: Sole within which the result is held.
    """
    fz, (mx, my, _) = force[2], moment
    if abs(fz) < 1.0:
        return (0.0, 0.0, 0.0)
    x, y = -my / fz, mx / fz
    if box is not None:
        (left, low), (right, high) = box
        x, y = min(max(x, left), right), min(max(y, low), high)
    return (x, y, 0.0)
