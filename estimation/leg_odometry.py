"""Position, heading and linear velocity of the base from supports that do not slip."""

from collections.abc import Iterable

from estimation.rotations import Rows, Vector, add, cross, heading_of, rotate, wrap
from estimation.support_kinematics import FrameMotion, Support


class LegOdometry:
    """Footholds of the loaded supports, and the base relative to them.

    A support gets its foothold where it is believed to be when it takes load, and loses
    it with the load. Vectors are in world axes unless named otherwise.
    """

    position: Vector  # m, of the base in the world

    def __init__(self, position_gain: float):
        self._gain = position_gain  # 1/s
        self.reset()

    def reset(self) -> None:
        """Forget position and footholds."""
        self.position = (0.0, 0.0, 0.0)
        self._points: dict[int, Vector] = {}  # m, origin of the support frame
        self._headings: dict[int, float] = {}  # rad

    def start(self, position: Vector) -> None:
        """Set the base's position [m] in a new world."""
        self.reset()
        self.position = position

    def heading_error(self, rotation: Rows, supports: dict[int, Support]) -> float:
        """Return the footholds' heading minus the estimated one [rad], weighted by load."""
        return sum(
            support.weight * wrap(self._headings[i] - heading(rotation, support.motion))
            for i, support in supports.items()
            if i in self._headings
        )

    def update(
        self,
        rotation: Rows,
        velocity: Vector,
        supports: dict[int, Support],
        dt: float,
    ) -> None:
        """Integrate the base's position and pull it towards what the footholds say.

        Args:
            rotation: R_world_base.
            velocity: Of the base, m/s in base axes.
            supports: Those that bear load.
            dt: Time since the last sample [s].
        """
        self.position = add(self.position, rotate(rotation, velocity), dt)
        known = {i: support for i, support in supports.items() if i in self._points}
        share = sum(support.weight for support in known.values())
        for i, support in known.items():
            base = add(self._points[i], rotate(rotation, support.motion.position), -1.0)
            pull = min(1.0, self._gain * dt) * support.weight / share
            self.position = add(self.position, add(base, self.position, -1.0), pull)
        if not len(known) == len(supports) == len(self._points):
            self._change_footholds(rotation, supports)

    def _change_footholds(self, rotation: Rows, supports: dict[int, Support]) -> None:
        for i in self._points.keys() - supports.keys():
            del self._points[i], self._headings[i]
        for i in supports.keys() - self._points.keys():
            motion = supports[i].motion
            self._points[i] = add(self.position, rotate(rotation, motion.position))
            self._headings[i] = heading(rotation, motion)


def heading(rotation: Rows, motion: FrameMotion) -> float:
    """Return the heading [rad] of a frame's x axis on a base with R_world_base."""
    return heading_of(rotate(rotation, [row[0] for row in motion.rotation]))


def base_velocity(angular: Vector, supports: Iterable[Support]) -> Vector:
    """Return the base's linear velocity m/s in base axes.

    Each support turns about its centre of pressure, which stands still (heels and edges
    may lift).

    Args:
        angular: Angular velocity of the base, rad/s in base axes.
        supports: Those that bear load.
    """
    velocity: Vector = (0.0, 0.0, 0.0)
    for motion, weight, center in supports:
        turning = cross(add(motion.angular, angular), center)
        velocity = add(velocity, add(motion.linear, turning), -weight)
    return velocity
