"""A sequence of postures, one after the other, as in the thesis's "Yoga" demo."""

import numpy as np

from robot_model import Robot

Array = np.ndarray
MOVE, HOLD = 2.5, 0.5  # s
SHARE = 0.6  # of the way from home to a joint's limits, at most


class LimbMotion:
    """Smooth moves (minimum jerk) between random postures within the joint limits.

    Starts and ends at home. Nobody looks whether limbs would collide: the simulated
    robot has no skin.

    Args:
        robot: Gives home and limits.
        seed: Of the postures.
        postures: How many there are between the two at home.
    """

    def __init__(self, robot: Robot, seed: int, postures: int):
        random = np.random.default_rng(seed)
        lower, upper = (
            robot.home + SHARE * (np.clip(limit, -np.pi, np.pi) - robot.home)
            for limit in (robot.position_lower, robot.position_upper)
        )
        chosen = random.uniform(lower, upper, (postures, robot.n))
        self._postures = np.vstack([robot.home, chosen, robot.home])
        self.duration = (postures + 1) * (MOVE + HOLD)  # s

    def position(self, time: float) -> Array:
        """Return the joint positions (n,) [rad] at a time [s] from the start."""
        index, elapsed = divmod(min(max(time, 0.0), self.duration - 1e-9), MOVE + HOLD)
        share = min(1.0, elapsed / MOVE)
        step = share**3 * (10.0 - 15.0 * share + 6.0 * share**2)
        start, goal = self._postures[int(index) : int(index) + 2]
        return start + step * (goal - start)
