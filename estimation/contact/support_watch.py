"""Do the supports stand as they should? What rocks or lands is no time to learn offsets in."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from estimation.support_kinematics import center_of_pressure
from robot_model import Robot

Array = np.ndarray


@dataclass(frozen=True)
class SupportLimits:
    """Beyond one of these a support is unsteady."""

    margin: float = 0.005  # m, from the centre of pressure to the edge of the sole
    load: float = 20.0  # N, least
    rate: float = 600.0  # N/s, of the load; 100 N that sway at 0.5 Hz from foot to foot make 310
    settle: float = 0.5  # s of steadiness before anything is learnt again


class SupportWatch:
    """Judges each support by the force/torque sensor that its sole is rigidly fixed to.

    Supports without such a sensor, or without a known sole, are taken as steady.
    Detection itself assumes nothing of the feet, whose wrench is measured and taken off;
    a heel that lifts is told, and no touch.
    """

    def __init__(self, robot: Robot, frames: Sequence[str], limits: SupportLimits | None = None):
        self._limits = limits or SupportLimits()
        self._feet = [foot for frame in frames if (foot := _Foot.of(robot, frame)) is not None]
        self.reset()

    def reset(self) -> None:
        """Forget loads, as after a jump of the stamps."""
        self._stamp: int | None = None
        self._unsteady: int | None = None  # last stamp at which a support was unsteady
        self._loads: dict[int, float] = {}

    def look(self, ft: Array, valid: Array, stamp: int) -> dict[int, str]:
        """Return why supports are unsteady, by the index of their sub-tree.

        Args:
            ft: (k, 6) readings.
            valid: (k,) of the sensors.
            stamp: [ns]
        """
        period = 0.0 if self._stamp is None else (stamp - self._stamp) * 1e-9
        self._stamp, reasons = stamp, {}
        for foot in self._feet:
            if valid[foot.sensor]:
                reason = self._judge(foot, ft[foot.sensor], period)
                reasons |= {foot.subtree: reason} if reason else {}
        if reasons:
            self._unsteady = stamp
        return reasons

    def is_steady(self, stamp: int) -> bool:
        """Whether all supports have been steady for a while."""
        since = self._unsteady
        return since is None or stamp - since > self._limits.settle * 1e9

    def _judge(self, foot: "_Foot", reading: Array, period: float) -> str:
        limits, wrench = self._limits, foot.wrench(reading)
        load, before = wrench[2], self._loads.get(foot.sensor)
        self._loads[foot.sensor] = load
        if load < limits.load:
            return f"is hardly loaded ({load:.0f} N)"
        if before is not None and period and abs(load - before) > limits.rate * period:
            return f"is loaded or relieved fast ({(load - before) / period:.0f} N/s)"
        margin = foot.margin(wrench)
        if margin < limits.margin:
            return f"stands on the edge of its sole ({1e3 * margin:.0f} mm)"
        return ""


@dataclass(frozen=True, eq=False)
class _Foot:
    """A sole and the sensor that bears it."""

    subtree: int
    sensor: int
    turn: Array  # (6, 6) wrenches from the sensor to the sole
    low: list[float]  # (2,) m, corner of the sole
    high: list[float]

    @classmethod
    def of(cls, robot: Robot, frame: str) -> "_Foot | None":
        subtree = robot.subtree_of(frame)
        sensor, corners = robot.subtrees[subtree].ft_in, robot.soles.get(frame)
        if sensor < 0 or corners is None:
            return None
        tree = robot.tree
        sole = tree.model.frames[tree.frame_id(frame)]
        bearer = tree.model.frames[tree.frame_id(robot.ft_frames[sensor])]
        if sole.parentJoint != bearer.parentJoint:
            return None
        turn = sole.placement.actInv(bearer.placement).toDualActionMatrix()
        low, high = corners[:, :2].min(axis=0), corners[:, :2].max(axis=0)
        return cls(subtree, sensor, turn, low.tolist(), high.tolist())

    def wrench(self, reading: Array) -> list[float]:
        """Wrench of the floor on the sole, in its axes and about its origin."""
        return (-self.turn.dot(reading)).tolist()

    def margin(self, wrench: list[float]) -> float:
        """Distance from the centre of pressure to the nearest edge, negative outside [m]."""
        center = center_of_pressure(wrench[:3], wrench[3:], None)
        edges = zip(center, self.low, self.high, strict=False)
        return min(min(at - low, high - at) for at, low, high in edges)
