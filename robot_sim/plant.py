"""The plant: a robot with motors, boards, floor and sensors, one millisecond at a time."""

from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from robot_model import Robot, build_tree
from robot_model.messages import GroundTruth, RawFrame
from robot_sim.boards import Boards, Mode
from robot_sim.body import Body, PlantDiverged
from robot_sim.contact import Floor, SoleContacts, placement, stands_on
from robot_sim.friction import JointFriction
from robot_sim.motions import Motion, followed
from robot_sim.noise import Noise, load_profile
from robot_sim.pushes import RISE, Pushes, PushShape
from robot_sim.raw_frame import all_valid, raw_frame
from robot_sim.sensors import ExactSensors, Readings
from robot_sim.standing import standing_base

Array = np.ndarray
Base = Literal["free", "fixed"]

TICK = 1_000_000  # ns


class PlantConfig(BaseModel):
    """Parameters of the plant that belong to no robot."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    floor: Floor = Floor()
    watchdog: bool = False  # silence fades the feed-forward; for plants driven over the bus
    fall_tilt: float = Field(default=0.7, gt=0)  # rad from the standing posture: fallen
    fall_drop: float = Field(default=0.1, gt=0)  # m below the standing posture: fallen
    pole_lift: float = Field(default=0.3, ge=0)  # m, how far the pole lifts the soles off the floor
    coulomb_speed: float = Field(default=0.02, gt=0)  # rad/s over which Coulomb friction turns sign


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
        q, dq: Joint positions [rad] and velocities [rad/s] (n,) at that time.
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
        self._contacts = None
        if stands_on(robot):
            self._contacts = SoleContacts(robot, self._body.data, cut, self.config.floor)
        self._pushes = Pushes(robot, self._body.data, cut)
        self._joint_q, self._joint_v = robot.tree.joint_q, robot.tree.joint_v
        self._standing = standing_base(robot, self.config.floor)
        self._up = self._standing.rotation[2].copy()  # in base axes, while standing
        self._up_now = self._body.data.oMi[1].rotation[2]  # the same at this instant, a view
        self._lowest = self._standing.translation[2] - self.config.fall_drop  # m
        self._least_upright = np.cos(self.config.fall_tilt)
        self._valid = all_valid(robot.dimensions)
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
        rise: float = RISE,
    ) -> int:
        """Push a link from the next step on, and return the push's id.

        Args:
            link: Name of a body (see ``robot.links``).
            point: Where, (3,) [m] in the link's frame.
            force: Largest force (3,) [N], on the robot.
            frame: Axes of the force, ``link`` or ``world``.
            profile: ``hold``, ``ramp`` or ``half_sine``.
            duration: [s]; None lasts until ``release`` (not for half_sine).
            rise: Of a ramp [s], half the duration at most.

        Raises:
            LookupError: unknown link; the text proposes a near one.
            ValueError: any other argument is wrong.
        """
        start = (self.time + TICK) * 1e-9
        shape = PushShape(profile, np.inf if duration is None else float(duration), rise)
        return self._pushes.add(link, point, force, frame, shape, start)

    def release(self, push_id: int | None = None) -> list[int]:
        """End a push, or all of them; returns the ids that ended."""
        return self._pushes.release(push_id)

    def motion(self, motion: Motion | None) -> None:
        """Add a motion to the position reference, or fade the present one out."""
        self._motion = followed(self._motion, motion, self.robot, self.time * 1e-9)

    def profile(self, name: str | Path) -> None:
        """Change the noise profile; biases are drawn anew from the seed."""
        n, k, m = (self.robot.dimensions[d] for d in "nkm")
        self.noise = Noise(load_profile(name), n, k, m, self.seed, self.robot.inertial_sensors)
        coulomb = self.noise.profile.coulomb
        self._friction = JointFriction(self.robot, coulomb, self.config.coulomb_speed)
        self.profile_name = str(name)

    def base(self, base: Base) -> None:
        """Put the robot on the pole (``fixed``) or on the floor (``free``), and reset."""
        if base not in ("free", "fixed"):
            raise ValueError(f"base must be 'free' or 'fixed', got {base!r}")
        if base == "free" and self._contacts is None:
            raise ValueError(
                f"{self.robot.name} has no soles to stand on; its base must be 'fixed'"
            )
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
        base = self._standing.copy()
        if self.base_mode == "fixed":
            base.translation[2] += self.config.pole_lift
        home = self.robot.tree.configuration(self.robot.home, base)
        self._body.place(home, self.base_mode == "fixed")
        if self._contacts is not None:
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
            raise PlantDiverged(
                f"the plant diverged at {self.time * 1e-9:.3f} s: {error}"
            ) from None
        self._body.update_kinematics()

    def _evaluate(self) -> None:
        """Find all forces and the acceleration of the present state."""
        body = self._body
        self._find_forces()
        q, dq = self._update_joints()
        motor_torque = self.boards.torque(q, dq, self._motion_offset())
        self._friction_torque, slope = self._friction.evaluate(dq)
        body.accelerate(motor_torque - self._friction_torque, slope)

    def _motion_offset(self) -> Array | None:
        now = self.time * 1e-9
        if self._motion is not None and self._motion.ended(now):
            self._motion = None
        return None if self._motion is None else self._motion.offset(now)

    def _update_joints(self) -> tuple[Array, Array]:
        self.q, self.dq = self._body.q[self._joint_q], self._body.v[self._joint_v]
        self._readings = None
        return self.q, self.dq

    def _find_forces(self) -> None:
        whole, cut = self._body.forces, self._exact.forces
        whole.clear()
        cut.clear()
        if self.base_mode == "free" and self._contacts is not None:
            self._contacts.evaluate()
            self._contacts.add_to(whole, cut)
        if self._pushes.active:
            self._pushes.evaluate(self.time * 1e-9)
        else:
            self._pushes.acting = []
        for push, force in self._pushes.acting:
            whole.add(push.joint, push.wrench_map @ force)
            cut.add(push.joint_cut, push.wrench_map_cut @ force)

    def _freeze(self) -> None:
        """Hold the fallen robot where it is: its body has no contacts besides the soles."""
        self._body.halt()
        self._pushes.restart()
        if self._contacts is not None:
            self._contacts.release()
        self._body.forces.clear()
        self._exact.forces.clear()
        self._friction_torque = np.zeros(self.robot.n)
        self._update_joints()

    def _has_fallen(self) -> bool:
        if self.base_mode == "fixed":
            return False
        upright = self._up_now.dot(self._up)
        return bool(upright < self._least_upright or self._body.q[2] < self._lowest)

    # -- what is seen of it

    @property
    def readings(self) -> Readings:
        """What exact sensors read at this instant."""
        if self._readings is None:
            self._readings = self._exact.read(self.q, self.dq, self._friction_torque)
        return self._readings

    def raw(self) -> RawFrame:
        """Return what the driver delivers at this instant, with the profile's errors."""
        return raw_frame(self.readings, self.noise, self._valid)

    def truth(self) -> GroundTruth:
        """Return everything the plant knows about this instant."""
        body, exact = self._body, self.readings
        frames, wrench = self._support_wrenches()
        return GroundTruth(
            q=exact.q,
            dq=exact.dq,
            ddq=exact.ddq,
            link_torque=exact.link_torque,
            motor_torque=exact.motor_torque,
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
    def motion_name(self) -> str:
        """Name of the present motion, empty without one."""
        return "" if self._motion is None else self._motion.name

    @property
    def pushes(self) -> list[int]:
        """Ids of the pushes that act now or begin with the next step."""
        return [push.id for push in self._pushes.active]

    def _support_wrenches(self) -> tuple[tuple[str, ...], Array]:
        if self.base_mode == "free" and self._contacts is not None:
            return self._contacts.frames, self._contacts.wrench_sole.copy()
        frame = self.robot.supports.get("pole", (self.robot.base_link,))[0]
        tree = self.robot.tree
        base_M_frame = placement(tree.model, tree.frame_id(frame)).joint_M_frame
        wrench = base_M_frame.inverse().toDualActionMatrix() @ self.readings.base_wrench
        return (frame,), wrench[None]
