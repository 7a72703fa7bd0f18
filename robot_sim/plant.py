"""The plant: a robot with motors, boards, floor and sensors, one millisecond at a time."""

from functools import cached_property
from pathlib import Path
from typing import Literal

import numpy as np
import pinocchio as pin
from pydantic import BaseModel, ConfigDict, Field
from robot_model import Robot, build_tree
from robot_model.messages import GroundTruth, RawFrame

from robot_sim.boards import Boards, Mode
from robot_sim.body import Body, PlantDiverged
from robot_sim.contact import Floor, SoleContacts, placement
from robot_sim.motions import Motion
from robot_sim.noise import Noise, load_profile
from robot_sim.pushes import Pushes
from robot_sim.sensors import ExactSensors, Readings

Array = np.ndarray
Base = Literal["free", "fixed"]

TICK = 1_000_000  # ns


class PlantConfig(BaseModel):
    """Parameters of the plant that belong to no robot."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    floor: Floor = Floor()
    watchdog: bool = False  # silence fades the feed-forward; for plants driven over the bus
    fall_tilt: float = Field(0.7, gt=0)  # rad from the standing posture: fallen
    fall_drop: float = Field(0.1, gt=0)  # m below the standing posture: fallen
    pole_lift: float = Field(0.3, ge=0)  # m, how far the pole lifts the soles off the floor
    coulomb_speed: float = Field(0.02, gt=0)  # rad/s over which Coulomb friction turns sign


class Plant:
    """A simulated robot. No bus, no clock, no thread: ``step`` moves it by 1 ms.

    After ``step``, ``raw`` and ``truth`` describe one and the same instant,
    ``time``: state, acceleration, forces and torques all belong to it. A command or a
    push acts from the next step on.

    Args:
        robot: From ``load_robot``.
        base: ``free`` stands on the floor, ``fixed`` hangs on a pole by its base link.
        profile: Name of a noise profile in ``robot_sim/profiles``, or a path.
        seed: Seed of the noise; equal seeds give equal runs, bit by bit.
        config: Floor and limits.

    Attributes:
        time: Simulated time [ns], a multiple of 1 ms.
        fallen: The robot fell: it is frozen where it is until ``reset``.
    """

    def __init__(
        self,
        robot: Robot,
        base: Base = "free",
        profile: str | Path = "ideal",
        seed: int = 0,
        config: PlantConfig | None = None,
    ):
        self.robot = robot
        self.config = config or PlantConfig()
        self.seed = seed
        self.boards = Boards(robot, TICK * 1e-9, self.config.watchdog)
        cut = build_tree(robot, robot.base_link, cut=True)
        self._body = Body(robot, TICK * 1e-9)
        self._exact = ExactSensors(robot, cut, self._body)
        self._contacts = SoleContacts(robot, self._body.data, cut, self.config.floor)
        self._pushes = Pushes(robot, self._body.data, cut)
        self._joint_q, self._joint_v = robot.tree.joint_q, robot.tree.joint_v
        self._standing = self._find_standing_base()
        self._motion: Motion | None = None
        self.profile(profile)
        self.base(base)

    # -- what a user does to the robot

    def command(
        self,
        position: Array | None = None,
        feedforward: Array | None = None,
        mode: Mode = "position",
    ) -> None:
        """Give the boards a command, which stands until the next one.

        Args:
            position: Reference (n,): rad, or rad/s and N m in the other modes; the
                home posture or the last reference stays when None.
            feedforward: Torque added to the boards' own (n,) [N m].

        Raises:
            ValueError: wrong shape, or a value that is not finite.
        """
        value = self.boards.reference if position is None else position
        self.boards.command(mode, value, feedforward)

    def push(
        self,
        link: str,
        point: Array,
        force: Array,
        frame: str = "link",
        profile: str = "hold",
        duration: float | None = None,
    ) -> int:
        """Push a link from the next step on, and return the push's id.

        Args:
            link: Name of a body (see ``robot.links``).
            point: Where, (3,) [m] in the link's frame.
            force: Largest force (3,) [N], on the robot.
            frame: Axes of the force, ``link`` or ``world``.
            profile: ``hold``, ``ramp`` (rises over 0.5 s) or ``half_sine``.
            duration: [s]; None lasts until ``release`` (not for half_sine).

        Raises:
            LookupError: unknown link; the text proposes a near one.
            ValueError: any other argument is wrong.
        """
        start = (self.time + TICK) * 1e-9
        return self._pushes.add(link, point, force, frame, profile, duration, start)

    def release(self, push_id: int | None = None) -> list[int]:
        """End a push, or all of them; returns the ids that ended."""
        return self._pushes.release(push_id)

    def motion(self, motion: Motion | None) -> None:
        """Add a motion to the position reference, or fade the present one out."""
        now = self.time * 1e-9
        if motion is not None:
            self._motion = motion.checked(self.robot).started(now)
        elif self._motion is not None:
            self._motion = self._motion.stopped(now)

    def profile(self, name: str | Path) -> None:
        """Change the noise profile; biases are drawn anew from the seed."""
        sizes = (self.robot.dimensions[d] for d in "nkm")
        self.noise = Noise(load_profile(name), *sizes, self.seed)
        self._friction = self.noise.profile.coulomb * np.asarray(self.robot.coulomb)
        self.profile_name = str(name)

    def base(self, base: Base) -> None:
        """Put the robot on the pole (``fixed``) or on the floor (``free``), and reset."""
        if base not in ("free", "fixed"):
            raise ValueError(f"base must be 'free' or 'fixed', got {base!r}")
        self.base_mode: Base = base
        self.reset()

    def reset(self) -> None:
        """Go back to the start of the run, bit by bit: home posture, time 0, same noise."""
        self.time = 0
        self.fallen = False
        self._motion = None
        self.boards.restart()
        self._pushes.restart()
        self.noise.restart()
        self._body.place(self._home_configuration(), self.base_mode == "fixed")
        self._contacts.restart()
        self._evaluate()

    # -- what a tick does

    def step(self) -> None:
        """Advance by one tick of 1 ms.

        Raises:
            PlantDiverged: the integration blew up; the state is lost until ``reset``.
        """
        self.time += TICK
        if not self.fallen:
            self._integrate()
            self.fallen = self._has_fallen()
        if self.fallen:
            self._freeze()
        else:
            self._evaluate()
        self.noise.draw()

    def _integrate(self) -> None:
        try:
            self._body.integrate()
        except PlantDiverged as error:
            raise PlantDiverged(f"the plant diverged at {self.time * 1e-9:.3f} s: {error}") from None
        self._body.update_kinematics()

    def _evaluate(self) -> None:
        """Find all forces and the acceleration of the present state."""
        body = self._body
        self._find_forces()
        q, dq = body.q[self._joint_q], body.v[self._joint_v]
        offset = None if self._motion is None else self._motion.offset(self.time * 1e-9)
        motor_torque = self.boards.torque(q, dq, offset)
        friction, slope = self._joint_friction(dq)
        body.accelerate(motor_torque - friction, slope)
        self._forget_readings()

    def _find_forces(self) -> None:
        whole, cut = self._body.forces, self._exact.forces
        whole.clear()
        cut.clear()
        if self.base_mode == "fixed":
            self._contacts.release()
        else:
            self._add_contacts()
        if self._pushes.active:
            self._pushes.evaluate(self.time * 1e-9)
        else:
            self._pushes.acting = []
        for push, force in self._pushes.acting:
            whole.add(push.joint, push.wrench_map @ force)
            cut.add(push.joint_cut, push.wrench_map_cut @ force)

    def _add_contacts(self) -> None:
        contacts = self._contacts
        contacts.evaluate()
        for i, (joint, joint_cut) in enumerate(
            zip(contacts.joints, contacts.joints_cut, strict=True)
        ):
            self._body.forces.add(joint, contacts.wrench[i])
            self._exact.forces.add(joint_cut, contacts.wrench_cut[i])

    def _joint_friction(self, dq: Array) -> tuple[Array, Array]:
        """Return viscous and Coulomb friction against dq (n,) [N m], and its slope."""
        viscous = self.robot.viscous
        if not self._friction.any():
            return viscous * dq, viscous
        sign = np.tanh(dq / self.config.coulomb_speed)
        slope = self._friction * (1.0 - sign * sign) / self.config.coulomb_speed
        return viscous * dq + self._friction * sign, viscous + slope

    def _freeze(self) -> None:
        """Hold the fallen robot where it is: its body has no contacts besides the soles."""
        self._body.halt()
        self._pushes.restart()
        self._contacts.release()
        self._body.forces.clear()
        self._exact.forces.clear()
        self._forget_readings()

    def _has_fallen(self) -> bool:
        if self.base_mode == "fixed":
            return False
        base = self._body.data.oMi[1]
        upright = (base.rotation @ self._up)[2]
        drop = self._standing.translation[2] - base.translation[2]
        return bool(upright < np.cos(self.config.fall_tilt) or drop > self.config.fall_drop)

    # -- what is seen of it

    def _forget_readings(self) -> None:
        self.__dict__.pop("readings", None)

    @cached_property
    def readings(self) -> Readings:
        """What exact sensors read at this instant."""
        return self._exact.read()

    @property
    def q(self) -> Array:
        """Joint positions (n,) [rad]."""
        return self._body.q[self._joint_q]

    @property
    def dq(self) -> Array:
        """Joint velocities (n,) [rad/s]."""
        return self._body.v[self._joint_v]

    @property
    def ddq(self) -> Array:
        """Joint accelerations (n,) [rad/s^2]."""
        return self._body.a[self._joint_v]

    @property
    def motor_torque(self) -> Array:
        """Motor torque (n,) [N m]: link torque + A ddq + D dq + Coulomb friction.

        It differs from what the boards ask for by h D ddq, because the integrator
        lets friction act at the end of the tick.
        """
        friction, _ = self._joint_friction(self.dq)
        return self.readings.link_torque + self.robot.rotor_inertia @ self.ddq + friction

    def raw(self) -> RawFrame:
        """Return what the driver delivers at this instant, with the profile's errors."""
        noise, exact = self.noise, self.readings
        derivatives = noise.profile.derivatives
        ft = exact.ft.copy()
        ft[:, :3] += noise.on("ft_force")
        ft[:, 3:] += noise.on("ft_moment")
        n, k, m = self._valid
        return RawFrame(
            q=noise.encoder(self.q),
            dq=self.dq if derivatives else None,
            ddq=self.ddq if derivatives else None,
            motor_torque=self.motor_torque + noise.on("motor_torque"),
            ft=ft,
            imu_gyro=exact.gyro + noise.on("gyro"),
            imu_acc=exact.acceleration + noise.on("accelerometer"),
            imu_dgyro=exact.angular_acceleration if derivatives else None,
            imu_quat_wxyz=_orientation(exact.rotation, noise.on("orientation")),
            joint_valid=n,
            ft_valid=k,
            imu_valid=m,
        )

    def truth(self) -> GroundTruth:
        """Return everything the plant knows about this instant."""
        body, exact = self._body, self.readings
        frames, wrench = self._support_wrenches()
        return GroundTruth(
            q=self.q,
            dq=self.dq,
            ddq=self.ddq,
            link_torque=exact.link_torque,
            motor_torque=self.motor_torque,
            ft=exact.ft,
            base_position=body.q[:3].copy(),
            base_quat_wxyz=body.q[[6, 3, 4, 5]],
            base_twist=body.v[:6].copy(),
            base_acceleration=body.a[:6].copy(),
            pushes=self._pushes.truth(),
            support_frames=list(frames),
            support_wrench=wrench,
            fallen=self.fallen,
        )

    @property
    def pushes(self) -> list[int]:
        """Ids of the pushes that act now or begin with the next step."""
        return [push.id for push in self._pushes.active]

    @cached_property
    def _valid(self) -> tuple[Array, Array, Array]:
        n, k, m = (np.ones(self.robot.dimensions[d], dtype=bool) for d in "nkm")
        return n, k, m

    def _support_wrenches(self) -> tuple[tuple[str, ...], Array]:
        if self.base_mode == "free":
            return self._contacts.frames, self._contacts.wrench_sole.copy()
        frame = self.robot.supports["pole"][0]
        tree = self.robot.tree
        base_M_frame = placement(tree.model, tree.frame_id(frame)).joint_M_frame
        wrench = base_M_frame.inverse().toDualActionMatrix() @ self.readings.base_wrench
        return (frame,), wrench[None]

    # -- where it starts

    def _home_configuration(self) -> Array:
        base = self._standing.copy()
        if self.base_mode == "fixed":
            base.translation[2] += self.config.pole_lift
        return self.robot.tree.configuration(self.robot.home, base)

    def _find_standing_base(self) -> pin.SE3:
        """Place the base so that the soles, level, carry the weight at home posture."""
        tree, frames = self.robot.tree, self.robot.supports["floor"]
        data = tree.model.createData()
        home = tree.configuration(self.robot.home)
        pin.framesForwardKinematics(tree.model, data, home)
        soles = [data.oMf[tree.frame_id(frame)] for frame in frames]
        corners = [s.act(c) for s, f in zip(soles, frames, strict=True) for c in self.robot.soles[f]]
        level = soles[0].rotation.T
        weight = pin.computeTotalMass(tree.model) * 9.81
        sinking = weight / (len(corners) * self.config.floor.stiffness)
        middle = level @ np.mean([s.translation for s in soles], axis=0)
        lowest = min((level @ corner)[2] for corner in corners)
        self._up = level.T[:, 2]
        return pin.SE3(level, np.array([-middle[0], -middle[1], -lowest - sinking]))


def _orientation(rotation: Array, error: Array) -> Array:
    """Return quaternions wxyz (m, 4) of R_world_imu, turned by small errors (m, 3) [rad]."""
    quaternions = np.empty((len(rotation), 4))
    for row, matrix, turn in zip(quaternions, rotation, error, strict=True):
        x, y, z, w = (pin.Quaternion(matrix) * pin.Quaternion(pin.exp3(turn))).coeffs()
        row[:] = w, x, y, z
    return quaternions
