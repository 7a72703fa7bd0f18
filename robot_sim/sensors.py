"""What exact sensors read: one inverse dynamics of the tree cut at its F/T sensors."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from robot_model import Robot, TreeModel
from robot_sim.body import Body, ExternalForces
from robot_sim.contact import placement

Array = np.ndarray
Quaternion = tuple[float, float, float, float]


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
    attitude: list[Quaternion]  # (m,) wxyz, world from imu


class Imu:
    """One exact inertial sensor.

    Args:
        name: Its frame.
        cut: The tree cut at the F/T sensors.
        data: Its data after inverse dynamics, which makes ``a_gf`` the spatial
            acceleration less gravity's.
        whole: The body's tree, whose placements give the attitude.
        whole_data: Its data.
    """

    def __init__(
        self, name: str, cut: TreeModel, data: pin.Data, whole: TreeModel, whole_data: pin.Data
    ):
        place = placement(cut.model, cut.frame_id(name))
        self._joint_M_imu = place.joint_M_frame
        self._to_imu = np.ascontiguousarray(place.joint_M_frame.rotation.T)
        # Views, made once: an attribute of a Pinocchio object costs 0.7 us.
        self._twist, self._rate = data.v[place.joint], data.a_gf[place.joint]
        self._angular_twist, self._angular_rate = self._twist.angular, self._rate.angular
        self._frame = whole.model, whole_data, whole.frame_id(name)

    def read(self, out: Array) -> None:
        """Write gyro [rad/s], proper acceleration [m/s^2] and dgyro [rad/s^2] to (3, 3)."""
        out[0] = self._to_imu.dot(self._angular_twist)
        out[1] = pin.classicAcceleration(self._twist, self._rate, self._joint_M_imu)
        out[2] = self._to_imu.dot(self._angular_rate)

    def attitude(self) -> Quaternion:
        """Return the rotation from imu to world, wxyz."""
        *_, x, y, z, w = pin.SE3ToXYZQUATtuple(pin.updateFramePlacement(*self._frame))
        return w, x, y, z


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
        self._joint_v, self._cut_v, self._cut_sign = cut.joint_v, cut.cut_v, cut.cut_sign[:, None]
        self._place_state(robot.tree, cut)
        trees = cut, self._data, robot.tree, body.data
        self._imus = [Imu(name, *trees) for name in robot.imus]
        self._unmeasured = _unmeasured(robot)
        complete = [sensor.complete for sensor in robot.inertial_sensors]
        pairs = zip(self._imus, complete, strict=True)
        self._attitudes = [imu.attitude if whole else _no_attitude for imu, whole in pairs]

    def _place_state(self, tree: TreeModel, cut: TreeModel) -> None:
        """Allocate the cut tree's state, and find where the body's numbers go in it."""
        self._q = cut.neutral.copy()
        self._v, self._a = np.zeros(cut.model.nv), np.zeros(cut.model.nv)
        self._to_q, self._to_v = np.arange(tree.model.nq), np.arange(tree.model.nv)
        self._to_q[tree.joint_q], self._to_v[tree.joint_v] = cut.joint_q, cut.joint_v

    def read(self, q: Array, dq: Array, friction: Array) -> Readings:
        """Compute all readings of the present instant.

        Args:
            q, dq: The body's joint positions and velocities (n,), in the robot's order.
            friction: Friction torque at this instant (n,) [N m].
        """
        body = self._body
        ddq = body.a[body.joint_v]
        self._q[self._to_q], self._v[self._to_v], self._a[self._to_v] = body.q, body.v, body.a
        torque = pin.rnea(self._model, self._data, self._q, self._v, self._a, self.forces.list)
        link_torque = torque[self._joint_v]
        motion = np.empty((len(self._imus), 3, 3))
        for i, imu in enumerate(self._imus):
            imu.read(out=motion[i])
        if self._unmeasured is not None:
            motion[self._unmeasured] = 0.0
        return Readings(
            q=q,
            dq=dq,
            ddq=ddq,
            link_torque=link_torque,
            motor_torque=link_torque + self._rotor_inertia.dot(ddq) + friction,
            ft=torque[self._cut_v] * self._cut_sign,
            base_wrench=torque[:6],
            gyro=motion[:, 0],
            acceleration=motion[:, 1],
            angular_acceleration=motion[:, 2],
            attitude=[attitude() for attitude in self._attitudes],
        )


def _no_attitude() -> Quaternion:
    return 1.0, 0.0, 0.0, 0.0


def _unmeasured(robot: Robot) -> Array | None:
    """Return (m, 3): gyro, accelerometer, dgyro that a sensor has not; None where all have all."""
    has = [(s.gyro, s.accelerometer, s.gyro) for s in robot.inertial_sensors]
    lacks = ~np.array(has, dtype=bool).reshape(-1, 3)
    return lacks if lacks.any() else None
