"""All residuals of a robot, with what is valid, their offsets and their thresholds."""

from collections.abc import Mapping
from dataclasses import dataclass, field

import numpy as np

from estimation.contact.quiet_period import Quiet
from estimation.residual.fixed_base_residual import FixedBaseResidual
from estimation.residual.residual_model import is_measured
from estimation.residual.residuals import FloatingResiduals
from estimation.saturation import faults_by_name
from robot_model import Robot
from robot_model.messages import Residuals, SensorFrame
from robot_model.names import did_you_mean

Array = np.ndarray


@dataclass(frozen=True)
class ResidualSettings:
    """Gains in 1/s, floors of the thresholds in N m, N and N m."""

    internal_gain: float = 25.0  # of all joints ...
    joint_gains: Mapping[str, float] = field(default_factory=dict)  # ... but of these
    external_gain: float = 25.0
    classical: bool = False  # also on the floor, where it is wrong inside (R section II-C)
    sigmas: float = 6.0
    internal_floor: float = 0.3  # N m
    force_floor: float = 2.0  # N
    moment_floor: float = 0.5  # N m
    longest_gap: float = 0.05  # s without a sample, after which residuals start again


class ResidualBank:
    """Internal and external residuals where every support is measured, else the classical one.

    On a pole nobody measures the support: the internal and external residuals are then
    invalid, and the classical residual of a fixed base serves.
    """

    def __init__(self, robot: Robot, support: str, settings: ResidualSettings):
        self.robot = robot
        self.settings = settings
        n = robot.n
        self._zero_base = np.zeros(6)
        self._zero = np.zeros(n)
        self._fixed = None if is_measured(robot, support) else FixedBaseResidual(robot)
        self._floating = None if self._fixed else FloatingResiduals(robot, support)
        self._sensors = [robot.subtrees[robot.subtree_of(f)].ft_in for f in robot.supports[support]]
        self._offset, self._spread = np.zeros((2, 6 + 2 * n))  # external, internal, classical
        self.configure(settings)
        self._flags = (False, False, False)  # external, internal, classical
        self._stamp: int | None = None
        self.reason = "no sample yet"

    def configure(self, settings: ResidualSettings) -> None:
        """Change gains without a jump, and thresholds.

        Raises:
            LookupError: A gain of a joint that the robot does not have; nothing has changed.
        """
        gains = self._joint_gains(settings)
        self.settings = settings
        self._set_thresholds()
        if self._floating is not None:
            self._floating.set_gains(gains, settings.external_gain)
        if self._fixed is not None:
            self._fixed.set_gain(gains)

    def _joint_gains(self, settings: ResidualSettings) -> Array:
        """Return the gain of every joint, (n,) 1/s."""
        joints, gains = self.robot.joints, np.full(self.robot.n, settings.internal_gain)
        for name, gain in settings.joint_gains.items():
            if name not in joints:
                hint = did_you_mean(name, joints)
                raise LookupError(f"joint_gains: {self.robot.name} has no joint '{name}'{hint}")
            gains[joints.index(name)] = gain
        return gains

    def reset(self) -> None:
        """Start again from zero with the next sample; offsets stay."""
        for residual in (self._floating, self._fixed):
            if residual is not None:
                residual.reset()
        self._stamp = None

    def step(
        self, frame: SensorFrame, stamp: int, up_base: Array | None = None, due: bool = True
    ) -> None:
        """Take one sample; a gap or a lost channel starts the residuals again.

        Args:
            frame: All channels.
            stamp: Its time [ns], rising.
            up_base: Upwards in base axes, (3,) of length one; a fixed base needs it.
            due: Whether the residuals are wanted now. Every sample is integrated, the
                momenta of a floating base are computed only where it matters.
        """
        period = self._elapsed(stamp)
        self.reason = self._missing(frame, up_base)
        if self.reason:
            self._flags = (False, False, False)
            self.reset()
            return
        self._tell(frame.motor_torque_valid)
        if self._floating is not None:
            gyro, acc = frame.imu_gyro[0], frame.imu_acc[0]
            self._floating.add(frame.motor_torque, frame.ft, gyro, acc, period)
            if due:
                self._floating.evaluate(frame.q, frame.dq)
        elif self._fixed is not None and up_base is not None:
            self._fixed.step(frame.q, frame.dq, frame.motor_torque, up_base, period)

    def can_step_over(self, stamps: Array) -> bool:
        """Whether ``step_over`` serves at these times [ns]: a floating base, and no gap."""
        steps = np.diff(stamps, prepend=stamps[0] if self._stamp is None else self._stamp)
        return self._floating is not None and steps.max() * 1e-9 <= self.settings.longest_gap

    def step_over(
        self,
        stamps: Array,
        acting: tuple[Array, Array, Array, Array],
        motion: tuple[Array, Array],
        due: Array,
        torque_valid: bool,
    ) -> Array:
        """Take B complete samples at once; the numbers are those of ``step``.

        Args:
            stamps: Their times [ns], (B,) rising.
            acting: motor_torque, ft, gyro and acc of the first inertial sensor, (B, …) each.
            motion: q and dq, (B, n).
            due: (D,) indices of the samples at which residuals are wanted.
            torque_valid: Whether motor torques are measured.

        Returns:
            ``values`` at those samples, (D, 6 + 2 n).
        """
        assert self._floating is not None
        q, dq = motion
        periods = [self._elapsed(stamp) for stamp in stamps.tolist()]
        self._tell(torque_valid)
        return self._floating.evaluate_over(periods, acting, due, q[due], dq[due])

    def _tell(self, torque: bool) -> None:
        self.reason = ""
        if self._floating is not None:
            self._flags = (True, torque, torque and self.settings.classical)
        else:
            self._flags = (False, False, torque)

    def _elapsed(self, stamp: int) -> float:
        """Return the time since the last sample [s]; a gap starts the residuals again."""
        period = 0.0 if self._stamp is None else (stamp - self._stamp) * 1e-9
        if period > self.settings.longest_gap:
            self.reset()
        self._stamp = stamp
        return period

    def _missing(self, frame: SensorFrame, up_base: Array | None) -> str:
        """Why there is no residual at all, "" if there is."""
        robot, why = self.robot, faults_by_name(frame.faults)
        if not frame.joint_valid.all():
            return f"{robot.joints[int(np.argmin(frame.joint_valid))]} is invalid"
        if self._fixed is not None:
            return "" if up_base is not None else "no attitude of the base"
        if not frame.imu_valid[0]:
            return f"{robot.imus[0]} is {why.get(robot.imus[0], 'invalid')}"
        lost = [robot.ft_sensors[i] for i in self._sensors if not frame.ft_valid[i]]
        return f"{lost[0]} is {why.get(lost[0], 'invalid')}" if lost else ""

    @property
    def values(self) -> Array:
        """External, internal and classical residual before the tare, (6 + 2 n,)."""
        if self._floating is not None:
            return self._floating.values
        assert self._fixed is not None
        return np.concatenate((self._zero_base, self._zero, self._fixed.residual))

    def tare(self, quiet: Quiet) -> None:
        """Take offsets and thresholds from the statistics of a quiet period."""
        self._offset, self._spread = quiet.residual_mean.copy(), quiet.residual_std.copy()
        self._set_thresholds()

    @property
    def offset(self) -> Array:
        """What the tare takes from ``values``."""
        return self._offset

    @property
    def flags(self) -> tuple[bool, bool, bool]:
        """Whether the external, the internal and the classical residual are valid."""
        return self._flags

    def message(self) -> Residuals:
        """Return the residuals after the tare; those that are not valid are zero."""
        n, values = self.robot.n, self.values - self._offset
        external, internal, classical = self._flags
        joint_threshold = self._threshold[6 + n :] if self._fixed else self._threshold[6 : 6 + n]
        return Residuals(
            external=values[:6] if external else self._zero_base,
            internal=values[6 : 6 + n] if internal else self._zero,
            classical=values[6 + n :] if classical else self._zero,
            threshold_internal=joint_threshold,
            threshold_external=self._threshold[:6],
            valid_external=external,
            valid_internal=internal,
            valid_classical=classical,
        )

    def silent_message(self) -> Residuals:
        """Return a message that says nothing."""
        self._flags = (False, False, False)
        return self.message()

    @property
    def valid(self) -> bool:
        """Whether any residual is valid."""
        return any(self._flags)

    def _set_thresholds(self) -> None:
        settings = self.settings
        base = np.repeat([settings.force_floor, settings.moment_floor], 3)
        floor = np.concatenate((base, np.full(2 * self.robot.n, settings.internal_floor)))
        self._threshold = np.maximum(floor, settings.sigmas * self._spread)
