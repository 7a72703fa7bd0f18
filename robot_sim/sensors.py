"""What exact sensors read: one inverse dynamics of the tree cut at its F/T sensors."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from robot_model import Robot
from robot_model.tree import TreeModel

from robot_sim.body import Body, ExternalForces
from robot_sim.contact import placement

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Readings:
    """Exact readings of one instant."""

    link_torque: Array  # (n,) N m
    ft: Array  # (k, 6) parent on child, sensor frame
    base_wrench: Array  # (6,) what holds the root, base axes; zero when the base is free
    gyro: Array  # (m, 3) rad/s, imu axes
    acceleration: Array  # (m, 3) m/s^2, proper
    angular_acceleration: Array  # (m, 3) rad/s^2
    rotation: Array  # (m, 3, 3) R_world_imu


class ExactSensors:
    """Inverse dynamics of the cut tree at the plant's own state, acceleration and forces.

    Each F/T sensor is a joint with zero motion, so its entry in the torque vector is
    the wrench that crosses it; the bodies on its two sides are different bodies, and a
    push on the proximal one does not enter it.

    Args:
        robot: Gives sensors and frames.
        cut: Its tree cut at the F/T sensors, rooted like ``robot.tree``.
        body: The plant's body; its placements give the orientation of the IMUs.
    """

    def __init__(self, robot: Robot, cut: TreeModel, body: Body):
        self.forces = ExternalForces(cut.model)
        self._tree, self._model, self._data = cut, cut.model, cut.model.createData()
        self._body = body
        whole = robot.tree
        self._whole_q, self._whole_v = whole.joint_q, whole.joint_v
        self._q = cut.neutral.copy()
        self._v, self._a = np.zeros(cut.model.nv), np.zeros(cut.model.nv)
        self._sign = cut.cut_sign[:, None]
        places = [placement(cut.model, cut.frame_id(name)) for name in robot.imus]
        self._motion = np.array([p.joint_M_frame.toActionMatrixInverse() for p in places])
        self._views = [
            (self._data.v[p.joint].vector, self._data.a_gf[p.joint].vector) for p in places
        ]
        self._motions = np.zeros((len(places), 6, 2))
        mounts = [placement(whole.model, whole.frame_id(name)) for name in robot.imus]
        self._mounts = np.array([p.joint_M_frame.rotation for p in mounts])
        self._axes = [body.data.oMi[p.joint].rotation for p in mounts]

    def read(self) -> Readings:
        """Compute all readings of the present instant."""
        body, tree, q, v, a = self._body, self._tree, self._q, self._v, self._a
        q[:7], v[:6], a[:6] = body.q[:7], body.v[:6], body.a[:6]
        q[tree.joint_q] = body.q[self._whole_q]
        v[tree.joint_v] = body.v[self._whole_v]
        a[tree.joint_v] = body.a[self._whole_v]
        torque = pin.rnea(self._model, self._data, q, v, a, self.forces.list)
        for motions, (twist, acceleration) in zip(self._motions, self._views, strict=True):
            motions[:, 0], motions[:, 1] = twist, acceleration
        motion = self._motion @ self._motions
        gyro, linear = motion[:, 3:, 0], motion[:, :3, 0]
        return Readings(
            link_torque=torque[tree.joint_v],
            ft=torque[tree.cut_v] * self._sign,
            base_wrench=torque[:6],
            gyro=gyro,
            acceleration=motion[:, :3, 1] + _cross(gyro, linear),
            angular_acceleration=motion[:, 3:, 1],
            rotation=np.array(self._axes) @ self._mounts,
        )


NEXT, LAST = np.array([1, 2, 0]), np.array([2, 0, 1])


def _cross(left: Array, right: Array) -> Array:
    """Cross product of rows; np.cross costs ten times as much on a few rows."""
    return left[:, NEXT] * right[:, LAST] - left[:, LAST] * right[:, NEXT]
