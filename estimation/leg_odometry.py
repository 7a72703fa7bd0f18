"""Position, heading and linear velocity of the base from supports that do not slip."""

import numpy as np

from estimation.rotations import cross, heading_of, wrap
from estimation.support_kinematics import FrameMotion


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

    def heading_error(
        self, rotation: np.ndarray, supports: dict[int, FrameMotion], weights: dict[int, float]
    ) -> float:
        """Return the footholds' heading minus the estimated one [rad], weighted by load."""
        return sum(
            weights[i] * wrap(self._headings[i] - heading_of(rotation @ support.rotation))
            for i, support in supports.items()
            if i in self._headings
        )

    def update(
        self,
        rotation: np.ndarray,
        velocity: np.ndarray,
        supports: dict[int, FrameMotion],
        weights: dict[int, float],
        dt: float,
    ) -> None:
        """Integrate the base's position and pull it towards what the footholds say.

        Args:
            rotation: R_world_base (3, 3).
            velocity: Of the base, (3,) m/s in base axes.
            supports, weights: Loaded supports and their share of the load.
            dt: Time since the last sample [s].
        """
        self.position = self.position + dt * (rotation @ velocity)
        self._drop_unloaded(supports)
        known = [i for i in supports if i in self._points]
        share = sum(weights[i] for i in known)
        for i in known:
            base = self._points[i] - rotation @ supports[i].position
            pull = min(1.0, self._gain * dt) * weights[i] / share
            self.position = self.position + pull * (base - self.position)
        for i in supports:
            if i not in self._points:
                self._points[i] = self.position + rotation @ supports[i].position
                self._headings[i] = heading_of(rotation @ supports[i].rotation)

    def _drop_unloaded(self, supports: dict[int, FrameMotion]) -> None:
        for i in set(self._points) - set(supports):
            del self._points[i], self._headings[i]


def base_velocity(
    angular: np.ndarray,
    supports: dict[int, FrameMotion],
    weights: dict[int, float],
    centers: dict[int, np.ndarray],
) -> np.ndarray:
    """Return the base's linear velocity (3,) m/s in base axes.

    Each support turns about its centre of pressure, which stands still (heels and edges
    may lift).

    Args:
        angular: Angular velocity of the base, (3,) rad/s in base axes.
        supports: Motion of the loaded supports relative to the base.
        weights: Their share of the load; the shares add up to 1.
        centers: Centres of pressure (3,) m in the support frames.
    """
    velocity = np.zeros(3)
    for i, support in supports.items():
        arm = support.rotation @ centers[i]
        relative = support.linear + cross(support.angular, arm)
        velocity -= weights[i] * (relative + cross(angular, support.position + arm))
    return velocity
