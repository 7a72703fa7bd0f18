"""Where the frames of a robot are in the world."""

import numpy as np
import pinocchio as pin

from robot_model import Robot

Array = np.ndarray


class Placement:
    """Forward kinematics of a whole robot."""

    def __init__(self, robot: Robot):
        self._tree = robot.tree
        self._data = self._tree.model.createData()
        self._base = np.array([0.0, 0.0, 0.0, 0.0, 0.0, 0.0, 1.0])
        self._configuration = self._tree.configuration(robot.home)

    def update(self, q: Array, position: Array, quat_wxyz: Array) -> None:
        """Move the robot to joint positions (n,) [rad] and a pose of the base in the world."""
        self._base[:3] = position
        self._base[3:6] = quat_wxyz[1:]
        self._base[6] = quat_wxyz[0]
        self._base[3:] /= np.linalg.norm(self._base[3:]) or 1.0
        self._tree.configuration(q, self._base, self._configuration)
        pin.framesForwardKinematics(self._tree.model, self._data, self._configuration)

    def point(self, frame: str, point: Array) -> Array:
        """Return a point given in a frame, (3,) [m], in the world."""
        return self._data.oMf[self._tree.frame_id(frame)].act(point)

    def vector(self, frame: str, vector: Array) -> Array:
        """Return a vector given in a frame's axes, (3,), in the world's."""
        return self._data.oMf[self._tree.frame_id(frame)].rotation @ vector

    def inverse_point(self, frame: str, point: Array) -> Array:
        """Return a point given in the world, (3,) [m], in a frame."""
        return self._data.oMf[self._tree.frame_id(frame)].actInv(point)

    def inverse_vector(self, frame: str, vector: Array) -> Array:
        """Return a vector given in the world's axes, (3,), in a frame's."""
        return self._data.oMf[self._tree.frame_id(frame)].rotation.T @ vector

    def parents(self, frames: tuple[str, ...]) -> tuple[int, ...]:
        """Return, for each frame, the index of the one that carries it; -1 where none does."""
        model = self._tree.model
        joints = [model.frames[self._tree.frame_id(frame)].parentJoint for frame in frames]
        return tuple(_carrier(model, joint, joints) for joint in joints)

    def poses(self, frames: tuple[str, ...], parents: tuple[int, ...]) -> Array:
        """Return position and quaternion xyzw in the parent, or the world, (len(frames), 7)."""
        where = [self._data.oMf[self._tree.frame_id(frame)] for frame in frames]
        relative = (
            where[i] if parent < 0 else where[parent].actInv(where[i])
            for i, parent in enumerate(parents)
        )
        return np.array([pin.SE3ToXYZQUAT(placement) for placement in relative])


def _carrier(model: pin.Model, joint: int, joints: list[int]) -> int:
    while (joint := model.parents[joint]) > 0:
        if joint in joints:
            return joints.index(joint)
    return -1
