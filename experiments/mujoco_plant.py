"""MuJoCo as a plant: the robot's URDF, boards and noise in physics that are not ours."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from experiments.mujoco_robot import (
    add_force,
    add_force_torque,
    add_imu,
    add_rotors,
    bare_spec,
    mujoco,
    pose,
)
from robot_model import Robot
from robot_model.messages import RawFrame
from robot_sim import TICK, PlantConfig
from robot_sim.boards import Boards
from robot_sim.motions import Motion, followed
from robot_sim.noise import Noise, load_profile
from robot_sim.pushes import RISE, PushShape
from robot_sim.raw_frame import all_valid, raw_frame
from robot_sim.sensors import Quaternion, Readings
from robot_sim.standing import standing_base

Array = np.ndarray
THICKNESS = 0.01  # m, of the soles
UPRIGHT = np.cos(PlantConfig().fall_tilt)  # of the base's vertical, less is fallen


class MujocoPush(NamedTuple):
    """A push; point and force in the link's frame."""

    link: str
    point: Array  # m
    force: Array  # N
    shape: PushShape
    start: float  # s


class MujocoPlant:
    """What ``robot_sim.Plant`` offers to an experiment, moved and measured by MuJoCo.

    The base is clamped (``fixed``), or free with the soles on a floor. Rotors, board
    control, viscous and Coulomb friction and sensor noise are those of our plant;
    dynamics, floor and exact sensors are MuJoCo's. After ``step`` all that is read
    belongs to one instant, ``time``.

    Args:
        robot: From ``load_robot``.
        base: ``free`` or ``fixed``.
        profile: Noise profile.
        seed: Of the noise.

    Attributes:
        model, data: MuJoCo's; options of the model may be changed.
    """

    def __init__(self, robot: Robot, base: str = "free", profile: str = "ideal", seed: int = 0):
        self.robot, self.time = robot, 0
        self.support = "floor" if base == "free" else "pole"
        self.boards = Boards(robot, TICK * 1e-9, watchdog=False)
        n, k, m = (robot.dimensions[d] for d in "nkm")
        self.noise = Noise(load_profile(profile), n, k, m, seed, robot.inertial_sensors)
        self._viscous = np.array(robot.viscous)
        self._valid = all_valid(robot.dimensions)
        self._motion: Motion | None = None
        self._pushes: list[MujocoPush] = []
        self.model = self._build()
        self.data = mujoco.MjData(self.model)
        self._index()
        self._place()
        self.step()

    def _build(self):
        robot, spec = self.robot, bare_spec(self.robot)
        for name in robot.imus:
            add_imu(spec, robot, name)
        for frame in robot.supports[self.support]:
            self._add_support(spec, frame)
        add_rotors(spec, robot)
        if self.support == "floor":
            spec.body(robot.base_link).add_freejoint(name="base")
            spec.worldbody.add_geom(type=mujoco.mjtGeom.mjGEOM_PLANE, size=[1.0, 1.0, 0.1])
        model = spec.compile()
        model.opt.gravity[:] = [0.0, 0.0, -9.81]
        model.opt.timestep = TICK * 1e-9
        return model

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

    def _index(self) -> None:
        joints = [self.model.joint(name) for name in self.robot.joints]
        self._q = np.array([joint.qposadr[0] for joint in joints])
        self._v = np.array([joint.dofadr[0] for joint in joints])
        coulomb = self.noise.profile.coulomb * np.array(self.robot.coulomb)
        self.model.dof_frictionloss[self._v] = coulomb
        robot, every = self.robot, [np.zeros(0, dtype=int)]
        self._ft = np.concatenate([*map(self._sensors_on, robot.ft_sensors), *every])
        self._imu = np.concatenate([*map(self._sensors_on, robot.imus), *every])
        self._attitudes = [self.data.site(name).xmat for name in robot.imus]  # views

    def _sensors_on(self, site: str) -> Array:
        """Where the readings of the sensors on a site are, in the order of their adding."""
        mine = np.flatnonzero(self.model.sensor_objid == self.model.site(site).id)
        starts = self.model.sensor_adr[mine]
        return (starts[:, None] + np.arange(3)).reshape(-1)

    def _place(self) -> None:
        self.data.qpos[self._q] = self.robot.home
        if self.support == "floor":
            base = pose(standing_base(self.robot, PlantConfig().floor))
            self.data.qpos[:3], self.data.qpos[3:7] = base["pos"], base["quat"]
        self.time = -TICK

    # -- what a user does to the robot

    def push(
        self,
        link: str,
        point: Array,
        force: Array,
        profile: str = "hold",
        duration: float | None = None,
        rise: float = RISE,
    ) -> None:
        """Push a link from the next step on, as ``robot_sim.Plant.push`` in the link's frame."""
        shape = PushShape(profile, np.inf if duration is None else duration, rise)
        start = (self.time + TICK) * 1e-9
        link = self.robot.require_link(link)
        self._pushes.append(MujocoPush(link, np.array(point), np.array(force), shape, start))

    def release(self) -> None:
        """End all pushes."""
        self._pushes.clear()
        self.data.xfrc_applied[:] = 0.0

    def motion(self, motion: Motion | None) -> None:
        """Add a motion to the position reference, or fade the present one out."""
        self._motion = followed(self._motion, motion, self.robot, self.time * 1e-9)

    # -- what a tick does

    def step(self) -> None:
        """Advance by one tick of 1 ms."""
        model, data = self.model, self.data
        self.time += TICK
        mujoco.mj_step1(model, data)
        self.q, self.dq = data.qpos[self._q].copy(), data.qvel[self._v].copy()
        offset = None if self._motion is None else self._motion.offset(self.time * 1e-9)
        torque = self.boards.torque(self.q, self.dq, offset)
        data.qfrc_applied[self._v] = torque - self._viscous * self.dq
        self._push()
        mujoco.mj_step2(model, data)
        self._torque, self._readings = torque, None
        self.noise.draw()

    def _push(self) -> None:
        if not self._pushes:
            return
        self.data.xfrc_applied[:] = 0.0
        now = self.time * 1e-9
        self._pushes = [push for push in self._pushes if not push.shape.ended(now - push.start)]
        for push in self._pushes:
            body = self.data.body(push.link)
            rotation = body.xmat.reshape(3, 3)
            force = push.shape.amplitude(now - push.start) * push.force
            point = body.xpos + rotation @ push.point
            add_force(self.data, push.link, point, rotation @ force)

    def _dry_friction(self) -> Array:
        """Torque of Coulomb friction on the joints, (n,)."""
        data, torque = self.data, np.zeros(self.model.nv)
        if not self.noise.profile.coulomb:
            return torque[self._v]
        rows = np.flatnonzero(data.efc_type == mujoco.mjtConstraint.mjCNSTR_FRICTION_DOF)
        torque[data.efc_id[rows]] = data.efc_force[rows]
        return torque[self._v]

    def _inertial(self) -> tuple[Array, Array, Array]:
        """Gyro, proper and angular acceleration of the sensors, in their axes, (m, 3) each."""
        values = self.data.sensordata[self._imu].reshape(-1, 3, 3)
        turns = [np.reshape(rotation, (3, 3)).T for rotation in self._attitudes]
        dgyro = [turn @ row for turn, row in zip(turns, values[:, 2], strict=True)]
        return values[:, 0], values[:, 1], np.reshape(dgyro, (-1, 3))

    # -- what is seen of it

    @property
    def readings(self) -> Readings:
        """What exact sensors read at this instant; there is no ``base_wrench``."""
        if self._readings is None:
            self._readings = self._read()
        return self._readings

    def _read(self) -> Readings:
        robot, ddq = self.robot, self.data.qacc[self._v].copy()
        gyro, acceleration, dgyro = self._inertial()
        friction = self._viscous * self.dq - self._dry_friction()
        return Readings(
            q=self.q,
            dq=self.dq,
            ddq=ddq,
            link_torque=self._torque - friction - robot.rotor_inertia @ ddq,
            motor_torque=self._torque,
            ft=self.data.sensordata[self._ft].reshape(-1, 6),
            base_wrench=np.zeros(6),
            gyro=gyro,
            acceleration=acceleration,
            angular_acceleration=dgyro,
            attitude=[_quaternion(rotation) for rotation in self._attitudes],
        )

    def raw(self) -> RawFrame:
        """Return what the driver delivers at this instant, with the profile's errors."""
        return raw_frame(self.readings, self.noise, self._valid)

    @property
    def fallen(self) -> bool:
        """Whether the base has tilted too far to come back."""
        return bool(self.data.body(self.robot.base_link).xmat[8] < UPRIGHT)

    def pushed(self) -> dict[str, Array]:
        """Return the force on each link that is pushed now, (3,) N in its axes."""
        now = self.time * 1e-9
        return {p.link: p.shape.amplitude(now - p.start) * p.force for p in self._pushes}

    def support_wrenches(self) -> dict[str, Array]:
        """Return what bears the robot: (6,) by support frame, about it, in its axes."""
        frames = self.robot.supports[self.support]
        if self.support == "pole":
            return {frame: self.data.sensordata[self._sensors_on(frame)] for frame in frames}
        return {frame: self._contact_wrench(frame) for frame in frames}

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


def _quaternion(rotation: Array) -> Quaternion:
    """Return wxyz of a rotation (9,)."""
    quaternion = np.empty(4)
    mujoco.mju_mat2Quat(quaternion, rotation)
    w, x, y, z = quaternion.tolist()
    return w, x, y, z
