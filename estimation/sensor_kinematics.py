"""Where the frames of inertial sensors are, and how the joints move them."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from robot_model import Robot

Array = np.ndarray
CROSS = np.array([pin.skew(axis).T.reshape(9) for axis in np.eye(3)])


class SensorKinematics:
    """Motion of frames against the robot's base link, as if that stood still.

    All is in base axes. Frames of one body share its entry in Pinocchio's results, of
    which views are taken once.

    Attributes (S frames), set by ``update``:
        axes: (S, 3, 3) the frames' axes as rows; vectors as rows go through it into base axes.
        motion: (S, 5, 3) position, velocity, angular velocity, acceleration and angular
            acceleration; of the origins, m, m/s, rad/s, m/s^2 (classical), rad/s^2.
    """

    axes: Array
    motion: Array

    def __init__(self, robot: Robot, frames: Sequence[str]):
        self._tree, self._model = robot.tree, robot.tree.model
        self._data = self._model.createData()
        self._ids = [self._tree.frame_id(name) for name in frames]
        bearers = [self._model.frames[i] for i in self._ids]
        bodies, self._body = np.unique([b.parentJoint for b in bearers], return_inverse=True)
        self._views = [view for body in bodies.tolist() for view in self._of_body(body)]
        self._q = self._tree.neutral.copy()
        self._v, self._a = np.zeros((2, self._model.nv))
        self._mounting = np.array([b.placement.rotation.T for b in bearers])
        lever = np.array([b.placement.translation for b in bearers])
        self._lever_map = -cross_maps(lever)  # w @ map is w x lever
        self._local = np.zeros((len(bearers), 5, 3))
        self._local[:, 0] = lever

    def _of_body(self, body: int) -> list[Array]:
        pose, twist, rate = (x[body] for x in (self._data.oMi, self._data.v, self._data.a))
        motion = [twist.linear, twist.angular, rate.linear, rate.angular]
        return [pose.rotation.T.reshape(9), pose.translation, *motion]

    def update(self, q: Array, dq: Array, ddq: Array) -> None:
        """Follow joint positions, velocities and accelerations, (n,) rad, rad/s, rad/s^2."""
        tree = self._tree
        self._q[tree.joint_q], self._v[tree.joint_v], self._a[tree.joint_v] = q, dq, ddq
        pin.forwardKinematics(self._model, self._data, self._q, self._v, self._a)
        bodies = np.concatenate(self._views).reshape(-1, 24).take(self._body, axis=0)
        turned, twists = bodies[:, :9].reshape(-1, 3, 3), bodies[:, 12:].reshape(-1, 4, 3)
        turning, local = twists[:, 1::2], self._local  # w and alpha
        np.add(twists[:, ::2], turning @ self._lever_map, out=local[:, 1::2])
        local[:, 2::2] = turning
        local[:, 3] += np.vecmat(local[:, 1], cross_maps(twists[:, 1]))
        self.motion = local @ turned
        self.motion[:, 0] += bodies[:, 9:12]
        self.axes = self._mounting @ turned

    def jacobians(self, q: Array) -> Array:
        """Return (S, 6, n): [v w] of each frame, base axes, by joint velocity."""
        self._q[self._tree.joint_q] = q
        pin.computeJointJacobians(self._model, self._data, self._q)
        pin.updateFramePlacements(self._model, self._data)
        axes = pin.ReferenceFrame.LOCAL_WORLD_ALIGNED
        maps = [pin.getFrameJacobian(self._model, self._data, i, axes) for i in self._ids]
        return np.array(maps)[:, :, self._tree.joint_v]

    def moved_by(self) -> Array:
        """Return (S, n): whether a joint lies between the base link and a frame."""
        rng = np.random.default_rng(0)  # a posture at which no axis meets a frame by chance
        q = rng.uniform(0.1, 1.0, len(self._tree.joint_v))
        return np.abs(self.jacobians(q)).max(axis=1) > 0.0


def cross_maps(vectors: Array) -> Array:
    """Return (…, 3, 3) of vectors w (…, 3), by which x @ map is w x x."""
    return vectors.dot(CROSS).reshape(*vectors.shape[:-1], 3, 3)
