"""What exact sensors read: one inverse dynamics of the tree cut at its F/T sensors."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from robot_model import Robot, TreeModel
from robot_sim.body import Body, ExternalForces
from robot_sim.contact import placement

Array = np.ndarray


class Readings(NamedTuple):
    """Exact readings of one instant."""

    q: Array  # (n,) rad
    dq: Array  # (n,) rad/s
    ddq: Array  # (n,) rad/s^2
    link_torque: Array  # (n,) N m
    motor_torque: Array  # (n,) N m: link torque + A ddq + friction
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
        self._model, self._data, self._body = cut.model, cut.model.createData(), body
        self._rotor_inertia = np.array(robot.rotor_inertia)
        self._joint_q, self._joint_v = cut.joint_q, cut.joint_v
        self._cut_v, self._cut_sign = cut.cut_v, cut.cut_sign[:, None]
        self._q = cut.neutral.copy()
        self._v, self._a = np.zeros(cut.model.nv), np.zeros(cut.model.nv)
        self._place_imus(robot, cut)

    def _place_imus(self, robot: Robot, cut: TreeModel) -> None:
        places = [placement(cut.model, cut.frame_id(name)) for name in robot.imus]
        data = self._data
        self._imus = [
            (
                data.v[p.joint].vector,
                data.a_gf[p.joint].vector,
                p.joint_M_frame.toActionMatrixInverse(),
            )
            for p in places
        ]
        tree = robot.tree
        mounts = [placement(tree.model, tree.frame_id(name)) for name in robot.imus]
        self._mounts = np.array([p.joint_M_frame.rotation for p in mounts])
        self._axes = [self._body.data.oMi[p.joint].rotation for p in mounts]

    def read(self, q: Array, dq: Array, friction: Array) -> Readings:
        """Compute all readings of the present instant.

        Args:
            q, dq: The body's joint positions and velocities (n,), in the robot's order.
            friction: Friction torque at this instant (n,) [N m].
        """
        body = self._body
        ddq = body.a[body.joint_v]
        self._q[:7], self._v[:6], self._a[:6] = body.q[:7], body.v[:6], body.a[:6]
        self._q[self._joint_q], self._v[self._joint_v], self._a[self._joint_v] = q, dq, ddq
        torque = pin.rnea(self._model, self._data, self._q, self._v, self._a, self.forces.list)
        link_torque = torque[self._joint_v]
        gyro, acceleration, angular = self._read_imus()
        return Readings(
            q=q,
            dq=dq,
            ddq=ddq,
            link_torque=link_torque,
            motor_torque=link_torque + self._rotor_inertia @ ddq + friction,
            ft=torque[self._cut_v] * self._cut_sign,
            base_wrench=torque[:6],
            gyro=gyro,
            acceleration=acceleration,
            angular_acceleration=angular,
            rotation=np.array(self._axes) @ self._mounts,
        )

    def _read_imus(self) -> tuple[Array, Array, Array]:
        """Return gyro, proper acceleration and angular acceleration of each IMU."""
        motion = np.empty((len(self._imus), 2, 6))
        for (twist, rate), (joint_twist, joint_rate, to_imu) in zip(
            motion, self._imus, strict=True
        ):
            np.dot(to_imu, joint_twist, out=twist)
            np.dot(to_imu, joint_rate, out=rate)
            vx, vy, vz, wx, wy, wz = twist.tolist()
            # From spatial to classical acceleration: w x v, without the 25 us of np.cross.
            rate[:3] += (wy * vz - wz * vy, wz * vx - wx * vz, wx * vy - wy * vx)
        return motion[:, 0, 3:], motion[:, 1, :3], motion[:, 1, 3:]
