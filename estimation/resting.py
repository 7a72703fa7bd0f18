"""The mean of a resting robot, and who is refused as moving."""

from dataclasses import dataclass

import numpy as np


class TareError(RuntimeError):
    """There is no tare, and why."""


class MovingError(TareError):
    """The robot moved while it had to rest."""


@dataclass(frozen=True)
class StillnessLimits:
    """A robot that exceeds one of these moves. Root mean squares over the window.

    A standard deviation of the readings beyond ``force_spread`` or ``moment_spread`` tells
    of somebody who touches a robot that its boards hold still.
    """

    joint_velocity: float  # rad/s, of any joint
    joint_travel: float  # rad, between the extremes of any joint
    angular_velocity: float  # rad/s, norm of the gyro's reading, its bias included
    force_spread: float = np.inf  # N, standard deviation of any component
    moment_spread: float = np.inf  # N m


@dataclass(frozen=True, eq=False)
class RestingMean:
    """Mean sample of a resting robot."""

    q: np.ndarray  # (n,) rad
    ft: np.ndarray  # (k, 6) readings, offsets included
    acc: np.ndarray  # (3,) m/s^2
    samples: int
    spread: np.ndarray  # (k, 6) standard deviation of the readings, N and N m


class RestingAverage:
    """Collects samples while the robot rests.

    Args:
        joints: Names of the n joints.
        limits: Who exceeds them moves.
        sensors: Names of the k force/torque sensors, for messages; numbers when left out.
        least: Fewer samples are no mean.
    """

    def __init__(
        self,
        joints: tuple[str, ...],
        limits: StillnessLimits,
        sensors: tuple[str, ...] = (),
        least: int = 1,
    ):
        self._joints, self._sensors = joints, sensors
        self._limits = limits
        self._least = least
        self._count = 0

    @property
    def samples(self) -> int:
        """How many have been added."""
        return self._count

    def add(
        self, q: np.ndarray, dq: np.ndarray, ft: np.ndarray, gyro: np.ndarray, acc: np.ndarray
    ) -> None:
        """Add one sample: (n,), (n,), (k, 6), (3,), (3,)."""
        if self._count == 0:
            self._sums = [np.zeros_like(x) for x in (q, dq, ft, acc, ft)]
            self._turning = 0.0
            self._lowest = self._highest = q
            self._first = ft.copy()  # squares about it lose no digits
        change = ft - self._first
        for total, value in zip(self._sums, (q, dq * dq, change, acc, change**2), strict=True):
            total += value
        self._turning += float(gyro @ gyro)
        self._lowest, self._highest = np.minimum(self._lowest, q), np.maximum(self._highest, q)
        self._count += 1

    @property
    def travel(self) -> np.ndarray:
        """Between the extremes of each joint, (n,) rad."""
        return self._highest - self._lowest

    def mean(self) -> RestingMean:
        """Return the mean.

        Raises:
            MovingError: Something moved, or too few samples came.
        """
        if self._count < max(1, self._least):
            came = f"{self._count} complete samples" if self._count else "no complete sample"
            raise MovingError(f"{came} came, expected {self._least}; tare needs every sensor")
        q, squares, change, acc, change2 = (total / self._count for total in self._sums)
        spread = np.sqrt(np.maximum(change2 - change**2, 0.0))
        turning = np.array([np.sqrt(self._turning / self._count)])
        self._check(np.sqrt(squares), turning, spread)
        return RestingMean(q, self._first + change, acc, self._count, spread)

    def _check(self, velocity: np.ndarray, turning: np.ndarray, spread: np.ndarray) -> None:
        c, travel = self._limits, self.travel
        sensors = self._sensors or tuple(f"sensor {i}" for i in range(len(spread)))
        gyro = ("the gyro",)
        _refuse("moves", self._joints, "at", velocity, c.joint_velocity, "rad/s")
        _refuse("moves", self._joints, "by", travel, c.joint_travel, "rad")
        _refuse("turns", gyro, "at", turning, c.angular_velocity, "rad/s")
        force, moment = spread[:, :3].max(axis=1), spread[:, 3:].max(axis=1)
        _refuse("is not at rest", sensors, "varies by", force, c.force_spread, "N (std)")
        _refuse("is not at rest", sensors, "varies by", moment, c.moment_spread, "N m (std)")


def _refuse(
    does: str, names: tuple[str, ...], verb: str, values: np.ndarray, limit: float, unit: str
) -> None:
    """Name the worst value beyond a limit."""
    if values.max(initial=0.0) > limit:
        worst = int(values.argmax())
        what = f"{names[worst]} {verb} {values[worst]:.3f} {unit}"
        raise MovingError(f"the robot {does}: {what}, limit {limit:g} {unit}")
