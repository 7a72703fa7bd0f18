"""Position, heading and linear velocity of the base from supports that do not slip."""

import math
from collections.abc import Iterable

import numpy as np

from estimation.rotations import cross, wrap
from estimation.support_kinematics import FrameMotion, Support


class LegOdometry:
    """Footholds of the loaded supports, and the base relative to them.

    A support gets its foothold where it is believed to be when it takes load, and loses
    it with the load. Vectors are in world axes unless named otherwise.
    """

    position: np.ndarray  # (3,) m, of the base in the world

    def __init__(self, position_gain: float):
        self._gain = position_gain  # 1/s
        self.reset()

    def reset(self) -> None:
        """Forget position and footholds."""
        self.position = np.zeros(3)
        self._points: dict[int, np.ndarray] = {}  # m, origin of the support frame
        self._headings: dict[int, float] = {}  # rad

    def start(self, position: np.ndarray) -> None:
        """Set the base's position (3,) [m] in a new world."""
        self.reset()
        self.position = position

    def heading_error(self, rotation: np.ndarray, supports: dict[int, Support]) -> float:
        """Return the footholds' heading minus the estimated one [rad], weighted by load."""
        return sum(
            support.weight * wrap(self._headings[i] - heading(rotation, support.motion))
            for i, support in supports.items()
            if i in self._headings
        )

    def update(
        self,
        rotation: np.ndarray,
        velocity: np.ndarray,
        supports: dict[int, Support],
        dt: float,
    ) -> None:
        """Integrate the base's position and pull it towards what the footholds say.

        Args:
            rotation: R_world_base (3, 3).
            velocity: Of the base, (3,) m/s in base axes.
            supports: Those that bear load.
            dt: Time since the last sample [s].
        """
        self.position = self.position + dt * (rotation @ velocity)
        known = {i: support for i, support in supports.items() if i in self._points}
        share = sum(support.weight for support in known.values())
        for i, support in known.items():
            base = self._points[i] - rotation @ support.motion.position
            pull = min(1.0, self._gain * dt) * support.weight / share
            self.position = self.position + pull * (base - self.position)
        if not len(known) == len(supports) == len(self._points):
            self._change_footholds(rotation, supports)

    def _change_footholds(self, rotation: np.ndarray, supports: dict[int, Support]) -> None:
        for i in self._points.keys() - supports.keys():
            del self._points[i], self._headings[i]
        for i in supports.keys() - self._points.keys():
            motion = supports[i].motion
            self._points[i] = self.position + rotation @ motion.position
            self._headings[i] = heading(rotation, motion)


def heading(rotation: np.ndarray, motion: FrameMotion) -> float:
    """Return the heading [rad] of a frame's x axis on a base with R_world_base (3, 3)."""
    x, y, _ = (rotation @ motion.rotation[:, 0]).tolist()
    return math.atan2(y, x)


def base_velocity(angular: np.ndarray, supports: Iterable[Support]) -> np.ndarray:
    """Return the base's linear velocity (3,) m/s in base axes.

    Each support turns about its centre of pressure, which stands still (heels and edges
    may lift).

    Args:
        angular: Angular velocity of the base, (3,) rad/s in base axes.
        supports: Those that bear load.
    """
    velocity = np.zeros(3)
    for motion, weight, center in supports:
        velocity -= weight * (motion.linear + cross(motion.angular + angular, center))
    return velocity
