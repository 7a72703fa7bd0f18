"""Where the inertial sensor and the supports are and how they move, seen from the base."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from robot_model import Robot

LOCAL = pin.ReferenceFrame.LOCAL


class FrameMotion(NamedTuple):
    """Pose and twist of a frame relative to the base link."""

    rotation: np.ndarray  # (3, 3) R_base_frame
    position: np.ndarray  # (3,) m, in base axes
    linear: np.ndarray  # (3,) m/s, of the origin, in base axes
    angular: np.ndarray  # (3,) rad/s, in base axes


class Load(NamedTuple):
    """What a support bears."""

    force: np.ndarray  # (3,) N, of the world on the robot, in base axes
    center: np.ndarray  # (3,) m, centre of pressure in the support frame


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

    def usable(self, joint_valid: np.ndarray, ft_valid: np.ndarray) -> np.ndarray:
        """Return (supports,): whether pose and load of a support can be computed."""
        return np.array(
            [
                joint_valid[path].all() and (sensor < 0 or ft_valid[sensor])
                for path, sensor in zip(self._joints, self._sensor, strict=True)
            ],
            dtype=bool,
        )

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
        twist = pin.getFrameVelocity(model, data, frame, LOCAL)
        rotation = placement.rotation.copy()
        linear, angular = rotation @ twist.linear, rotation @ twist.angular
        return FrameMotion(rotation, placement.translation.copy(), linear, angular)

    @property
    def without_sensor(self) -> bool:
        """Whether there are supports and their loads cannot be told from other contacts."""
        return bool(self._sensor) and min(self._sensor) < 0

    def load(self, index: int, ft: np.ndarray) -> Load:
        """Return what a support bears, from the readings (k, 6)."""
        sensor = self._sensor[index]
        model, data = self._tree.model, self._data
        base_m_sensor = pin.updateFramePlacement(model, data, self._ft_frames[sensor])
        base_m_support = pin.updateFramePlacement(model, data, self._frames[index])
        on_robot = base_m_sensor.act(pin.Force(-ft[sensor]))
        wrench = base_m_support.actInv(on_robot)
        center = center_of_pressure(wrench.vector, self.soles[index])
        return Load(on_robot.linear.copy(), center)


def center_of_pressure(wrench: np.ndarray, corners: np.ndarray | None) -> np.ndarray:
    """Return the centre of pressure (3,) m in the plane z = 0 of a support frame.

    Args:
        wrench: Of the world on the support, (6,) in the support frame, z upwards.
        corners: Sole corners (c, 3) m, within whose box the result is held.
    """
    _, _, fz, mx, my, _ = wrench.tolist()
    if abs(fz) < 1.0:
        return np.zeros(3)
    center = np.array([-my / fz, mx / fz, 0.0])
    if corners is not None:
        low, high = corners.min(axis=0), corners.max(axis=0)
        center[:2] = np.minimum(np.maximum(center[:2], low[:2]), high[:2])
    return center
