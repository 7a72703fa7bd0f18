"""MuJoCo as a plant of its own: a robot under position control, pushed, on floor or pole."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from robot_model import Robot
from robot_sim.contact import Floor
from robot_sim.standing import standing_base
from tests.estimation.observer_states import ObserverInput
from tests.mujoco_robot import add_force, add_force_torque, add_imu, bare_spec, mujoco, pose

Array = np.ndarray
ROTOR = 0.1  # kg m^2 at every joint, as on iCub's large ones
THICKNESS = 0.01  # m, of the soles


class TimedPush(NamedTuple):
    """A force that rises and falls like half a sine; link axes."""

    link: str
    point: tuple[float, float, float]  # m
    force: tuple[float, float, float]  # N
    start: float  # s
    duration: float  # s


class Moment(NamedTuple):
    """One instant: what the sensors read, and what is true."""

    reading: ObserverInput
    link_torque: Array  # (n,) N m
    pushes: dict[str, Array]  # (3,) force by link, in its axes, N
    supports: dict[str, Array]  # (6,) by support frame, about it, in its axes


class MujocoPlant:
    """A robot that starts at home, base clamped (``pole``) or free with soles on a floor."""

    def __init__(self, robot: Robot, support: str, pushes: Sequence[TimedPush]):
        self.robot, self.pushes, self.support = robot, pushes, support
        spec = bare_spec(robot)
        add_imu(spec, robot, robot.imus[0])
        self.frames = robot.supports[support]
        for frame in self.frames:
            self._add_support(spec, frame)
        if support == "floor":
            spec.body(robot.base_link).add_freejoint(name="base")
            spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1.0, 1.0, 0.1])
        self.model = spec.compile()
        self.model.opt.gravity[:] = [0.0, 0.0, -9.81]
        self.model.opt.timestep = 1e-3
        self.model.opt.tolerance = 1e-13  # the floor's forces must balance what they accelerate
        self.data = mujoco.MjData(self.model)
        joints = [self.model.joint(name) for name in robot.joints]
        self._q = np.array([joint.qposadr[0] for joint in joints])
        self._v = np.array([joint.dofadr[0] for joint in joints])
        self.model.dof_armature[self._v] = ROTOR
        self._place()

    def _add_support(self, spec, frame: str) -> None:
        link, link_m_frame = self.robot.frame(frame)
        if self.support == "pole":
            add_force_torque(spec, frame, link, link_m_frame)
            return
        corners = self.robot.soles[frame]
        middle, half = corners.mean(axis=0), np.ptp(corners, axis=0) / 2.0
        middle[2] += THICKNESS / 2.0
        place = pose(link_m_frame * pin.SE3(np.eye(3), middle))
        size = [half[0], half[1], THICKNESS / 2.0]
        box = mujoco.mjtGeom.mjGEOM_BOX
        spec.body(link).add_geom(name=frame, type=box, size=size, mass=0.0, **place)

    def _place(self) -> None:
        self.data.qpos[self._q] = self.robot.home
        if self.support == "floor":
            base = pose(standing_base(self.robot, Floor()))
            self.data.qpos[:3], self.data.qpos[3:7] = base["pos"], base["quat"]

    def step(self, goal: Array) -> None:
        """Advance by 1 ms towards a posture (n,) [rad]."""
        model, data, robot = self.model, self.data, self.robot
        mujoco.mj_step1(model, data)
        self._state = data.qpos[self._q].copy(), data.qvel[self._v].copy()
        self._torque = robot.board_kp * (goal - self._state[0]) - robot.board_kd * self._state[1]
        data.qfrc_applied[self._v] = self._torque
        self._forces = self._push()
        mujoco.mj_step2(model, data)

    def moment(self) -> Moment:
        """Return the instant before the last step: its accelerations, sensors and contacts."""
        ddq = self.data.qacc[self._v].copy()
        ft = self._force_torque(self.robot.ft_sensors)
        reading = ObserverInput(*self._state, ddq, ft, *self._imu())
        return Moment(reading, self._torque - ROTOR * ddq, self._forces, self._supports())

    def _push(self) -> dict[str, Array]:
        self.data.xfrc_applied[:] = 0.0
        forces = {}
        for push in self.pushes:
            share = (self.data.time - push.start) / push.duration
            size = np.sin(np.pi * share) if 0.0 < share < 1.0 else 0.0
            forces[push.link] = size * np.array(push.force)
            body = self.data.body(push.link)
            rotation = body.xmat.reshape(3, 3)
            point = body.xpos + rotation @ push.point
            add_force(self.data, push.link, point, rotation @ forces[push.link])
        return forces

    def _force_torque(self, names: Sequence[str]) -> Array:
        return np.array([self._sensors(name)[:6] for name in names])

    def _imu(self) -> tuple[Array, Array, Array]:
        """Gyro, proper acceleration, angular acceleration, in the sensor's axes."""
        name = self.robot.imus[0]
        gyro, acceleration, dgyro_world = self._sensors(name).reshape(3, 3)
        return gyro, acceleration, self.data.site(name).xmat.reshape(3, 3).T @ dgyro_world

    def _sensors(self, name: str) -> Array:
        """Readings of the sensors on a site, in the order in which they were added."""
        site = self.model.site(name).id
        mine = np.flatnonzero(self.model.sensor_objid == site)
        return np.concatenate(
            [self.data.sensordata[start : start + 3] for start in self.model.sensor_adr[mine]]
        )

    def _supports(self) -> dict[str, Array]:
        if self.support == "pole":
            return {frame: self._sensors(frame) for frame in self.frames}
        return {frame: self._contact_wrench(frame) for frame in self.frames}

    def _contact_wrench(self, frame: str) -> Array:
        """Sum of the floor's forces on a sole, about its frame."""
        data, geom = self.data, self.model.geom(frame).id
        link, link_m_frame = self.robot.frame(frame)
        body = data.body(link)
        world_m_frame = pin.SE3(body.xmat.reshape(3, 3), body.xpos) * link_m_frame
        total = np.zeros(6)
        for i, contact in enumerate(data.contact[: data.ncon]):
            if geom in contact.geom:
                wrench = np.zeros(6)
                mujoco.mj_contactForce(self.model, data, i, wrench)
                sign = 1.0 if contact.geom[1] == geom else -1.0  # of geom 1 on geom 2
                world_m_contact = pin.SE3(contact.frame.reshape(3, 3).T, contact.pos)
                total += sign * world_m_contact.act(pin.Force(wrench)).vector
        return world_m_frame.actInv(pin.Force(total)).vector
