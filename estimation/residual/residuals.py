"""Internal, external and classical residuals of a robot, sample by sample."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from estimation.residual.floating_dynamics import FloatingDynamics
from estimation.residual.free_fall import FreeFallVelocity
from estimation.residual.impulse import Impulse
from estimation.residual.momentum_filter import MomentumFilter
from estimation.residual.residual_model import is_measured
from robot_model import Robot

Array = np.ndarray


class ResidualSample(NamedTuple):
    """Residuals: generalised forces of touches, by the joints and by the base."""

    internal: Array  # (n,) N m, R eq. (11)
    external: Array  # (6,) [N, N m] in base axes about the base's origin, R eq. (16)
    classical: Array  # (n,) N m, R eq. (7)


class FloatingResiduals:
    """Residuals of a floating-base robot whose supports are measured.

    Torques are those of the motors: the momentum holds the rotors, and viscous and
    Coulomb friction are taken from the torques. Readings of the supports' sensors are
    known contacts (R eq. 10). The base's velocity is that of a freely falling frame
    (``FreeFallVelocity``), so neither attitude nor an estimate of the base is needed.

    Args:
        robot: The robot.
        support: Kind of support, "floor" or "none".
        internal_gain, external_gain: 1/s, scalar or (n,) and (6,).
        rebase_time: How long the frame falls before it is taken anew [s].
    """

    def __init__(
        self,
        robot: Robot,
        support: str = "floor",
        internal_gain: float | Array = 25.0,
        external_gain: float | Array = 25.0,
        rebase_time: float = 0.2,
    ):
        if not is_measured(robot, support):
            raise ValueError(f"support '{support}' of {robot.name} is not measured")
        self.robot = robot
        self._dynamics = FloatingDynamics(robot, support)
        self._classical = self._dynamics.joint_v
        self._internal = self._classical + robot.n
        self._told = np.concatenate((np.arange(6), self._internal, self._classical))
        self._filter = MomentumFilter(len(self._told), 1.0)
        self.set_gains(internal_gain, external_gain)
        self._fall, self._impulse = FreeFallVelocity(), Impulse()
        self._rebase_time = rebase_time
        self._age = -1.0  # [s] of the falling frame; negative before the first sample

    def set_gains(self, internal: float | Array, external: float | Array) -> None:
        """Set gains [1/s]; ``internal`` (n,) in the description's order, also for classical."""
        gain = np.ones_like(self._filter.gain)
        gain[:6] = external
        gain[self._internal] = internal
        gain[self._classical] = internal
        self._filter.gain = gain

    def reset(self) -> None:
        """Start again from zero with the next sample."""
        self._filter.reset()
        self._age = -1.0

    def step(
        self,
        q: Array,
        dq: Array,
        motor_torque: Array,
        ft: Array,
        gyro: Array,
        acc: Array,
        period: float,
    ) -> None:
        """Take one sample, ``period`` seconds after the last one; then see ``sample``.

        Args:
            q, dq, motor_torque: (n,) rad, rad/s, N m.
            ft: Readings, (k, 6) parent on child, sensor frames.
            gyro, acc: Angular velocity and proper acceleration of the first IMU, (3,).
        """
        self.add(motor_torque, ft, gyro, acc, period)
        self.evaluate(q, dq)

    def add(self, motor_torque: Array, ft: Array, gyro: Array, acc: Array, period: float) -> None:
        """Integrate what acts, at every sample; a tenth of the work of ``evaluate``."""
        first = self._age < 0.0
        if first:
            self._fall.reset(gyro, acc)
            self._age = 0.0
        else:
            self._fall.step(gyro, acc, period)
            self._age += period
        self._impulse.add(motor_torque, ft, 0.0 if first else period)

    def evaluate(self, q: Array, dq: Array) -> None:
        """Bring the residuals up to the sample added last, whose motion this is."""
        torque, ft, period, twist, old = self._interval()
        self._dynamics.place(q, dq, torque, ft)
        self._filter.step_terms(self._dynamics.terms(twist), period)
        if old:
            self._filter.rebase(self._dynamics.terms(_anew(twist)))

    def evaluate_over(
        self,
        periods: Sequence[float],
        acting: tuple[Array, Array, Array, Array],
        due: Array,
        q: Array,
        dq: Array,
    ) -> Array:
        """Take B samples and return ``values`` at D of them, (D, 6 + 2 n).

        They are those of ``add`` and ``evaluate``, of which all but Pinocchio runs at once.

        Args:
            periods: B times since the sample before [s].
            acting: motor_torque, ft, gyro and acc as in ``add``, stacked, (B, …) each.
            due: (D,) rising indices of the samples at which residuals are wanted.
            q, dq: (D, n) their motion.
        """
        wanted, intervals = set(due.tolist()), []
        for i, (period, torque, ft, gyro, acc) in enumerate(zip(periods, *acting, strict=True)):
            self.add(torque, ft, gyro, acc, period)
            if i in wanted:
                intervals.append(self._interval())
        values = np.zeros((len(intervals), len(self._told)))
        for row, (now, anew) in enumerate(self._terms_over(q, dq, intervals)):
            self._filter.step_terms(now, intervals[row].period)
            if intervals[row].old:
                self._filter.rebase(anew)
            values[row] = self.values
        return values

    def _terms_over(self, q: Array, dq: Array, intervals: list["_Interval"]) -> Array:
        """Return terms (D, 2, 3, 6 + 2 n): in the frame of each interval, and in one taken anew."""
        if not intervals:
            return np.zeros((0, 2, 3, 0))
        torque, ft, _, twist, old = map(np.array, zip(*intervals, strict=True))
        terms = np.zeros((len(q), 2, 3, len(self._told)))
        over = self._dynamics.terms_over
        terms[:, 0] = over(q, dq, torque, ft, twist).transpose(1, 0, 2)
        if old.any():
            again = over(q[old], dq[old], torque[old], ft[old], _anew(twist[old]))
            terms[old, 1] = again.transpose(1, 0, 2)
        return terms

    def _interval(self) -> "_Interval":
        """Return what acted since the last evaluation; an old frame falls anew from here."""
        torque, ft, period = self._impulse.take_mean()
        twist, old = self._fall.twist, self._age >= self._rebase_time
        if old:
            self._fall.rebase()
            self._age = 0.0
        return _Interval(torque, ft, period, twist, old)

    @property
    def sample(self) -> ResidualSample:
        """The residuals after the last step; zero after a reset."""
        values, n = self.values, self.robot.n
        return ResidualSample(values[6 : 6 + n], values[:6], values[6 + n :])

    @property
    def values(self) -> Array:
        """The same in one piece: external, internal and classical, (6 + 2 n,)."""
        return self._filter.residual.take(self._told)


class _Interval(NamedTuple):
    """What acted between two evaluations, and how the inertial sensor moves at its end."""

    torque: Array  # (n,) N m, mean
    ft: Array  # (k, 6) mean
    period: float  # s
    twist: Array  # (6,) in the falling frame
    old: bool  # the frame is to be taken anew


def _anew(twist: Array) -> Array:
    """Return twists (…, 6) in a frame that falls with the sensor at this instant."""
    twist = twist.copy()
    twist[..., :3] = 0.0
    return twist
