"""Where the frames of inertial sensors are, and how the joints move them."""

from collections.abc import Sequence

import numpy as np
import pinocchio as pin

from robot_model import Robot

Array = np.ndarray


class SensorKinematics:
    """Motion of frames against the robot's base link, as if that stood still.

    All is in base axes. Frames of one body share its entry in Pinocchio's results, of
    which views are taken once.

    Attributes (S frames), set by ``update``:
        rotation: (S, 3, 3) base axes from the frame's.
        position, velocity, acceleration: (S, 3) of the origins, m, m/s, m/s^2 (classical).
        angular_velocity, angular_acceleration: (S, 3) rad/s, rad/s^2.
    """

    rotation: Array
    position: Array
    velocity: Array
    angular_velocity: Array
    acceleration: Array
    angular_acceleration: Array

    def __init__(self, robot: Robot, frames: Sequence[str]):
        self._tree, self._model = robot.tree, robot.tree.model
        self._data = self._model.createData()
        self._ids = [self._tree.frame_id(name) for name in frames]
        bearers = [self._model.frames[i] for i in self._ids]
        bodies, self._body = np.unique([b.parentJoint for b in bearers], return_inverse=True)
        self._views = [view for body in bodies.tolist() for view in self._of_body(body)]
        self._q = self._tree.neutral.copy()
        self._v, self._a = np.zeros((2, self._model.nv))
        self._mounting = np.array([b.placement.rotation for b in bearers])
        self._lever = np.array([b.placement.translation for b in bearers])
        self._lever_map = -np.array([pin.skew(c) for c in self._lever])  # w -> w x lever
        self._local = np.zeros((len(bearers), 3, 5))
        self._local[..., 0] = self._lever

    def _of_body(self, body: int) -> list[Array]:
        pose, twist, rate = (x[body] for x in (self._data.oMi, self._data.v, self._data.a))
        motion = [twist.linear, twist.angular, rate.linear, rate.angular]
        return [pose.rotation.T.reshape(9), pose.translation, *motion]

    def update(self, q: Array, dq: Array, ddq: Array) -> None:
        """Follow joint positions, velocities and accelerations, (n,) rad, rad/s, rad/s^2."""
        tree = self._tree
        self._q[tree.joint_q], self._v[tree.joint_v], self._a[tree.joint_v] = q, dq, ddq
        pin.forwardKinematics(self._model, self._data, self._q, self._v, self._a)
        bodies = np.concatenate(self._views).reshape(-1, 24)[self._body]
        turned = bodies[:, :9].reshape(-1, 3, 3).swapaxes(1, 2)
        v, w, a, alpha = bodies[:, 12:].reshape(-1, 4, 3).swapaxes(0, 1)
        local, lever = self._local, self._lever_map
        local[..., 1] = velocity = v + np.matvec(lever, w)
        local[..., 2] = w
        local[..., 3] = a + np.matvec(lever, alpha) + cross(w, velocity)
        local[..., 4] = alpha
        position, self.velocity, self.angular_velocity, self.acceleration, rate = (
            turned @ local
        ).transpose(2, 0, 1)
        self.position, self.angular_acceleration = position + bodies[:, 9:12], rate
        self.rotation = turned @ self._mounting

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


def cross(a: Array, b: Array) -> Array:
    """Return the cross product along the last axis; np.cross takes five times as long."""
    a1, a2, a3 = a[..., 0], a[..., 1], a[..., 2]
    b1, b2, b3 = b[..., 0], b[..., 1], b[..., 2]
    out = np.empty(np.broadcast_shapes(a.shape, b.shape))
    out[..., 0] = a2 * b3 - a3 * b2
    out[..., 1] = a3 * b1 - a1 * b3
    out[..., 2] = a1 * b2 - a2 * b1
    return out
