"""Friction in the joints."""

import numpy as np

from robot_model import Robot

Array = np.ndarray


class JointFriction:
    """Viscous friction, and Coulomb friction where a noise profile turns it on.

    Args:
        robot: Gives both coefficients.
        coulomb: Factor on the robot's Coulomb friction; 0 for none.
        speed: Joint speed [rad/s] over which Coulomb friction turns its sign.
    """

    def __init__(self, robot: Robot, coulomb: float, speed: float):
        self._viscous = np.array(robot.viscous)
        self._coulomb = coulomb * np.array(robot.coulomb)
        self._speed = speed
        self._dry = bool(self._coulomb.any())

    def evaluate(self, dq: Array) -> tuple[Array, Array]:
        """Return the torque that friction takes from the motors, and its slope.

        Args:
            dq: Joint velocity (n,) [rad/s].

        Returns:
            Torque (n,) [N m], positive for positive dq; slope (n,) [N m s/rad].
        """
        if not self._dry:
            return self._viscous * dq, self._viscous
        sign = np.tanh(dq / self._speed)
        slope = self._viscous + self._coulomb * (1.0 - sign * sign) / self._speed
        return self._viscous * dq + self._coulomb * sign, slope
