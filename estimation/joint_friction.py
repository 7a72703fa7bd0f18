"""Friction of the joints, as the robot's description gives it."""

import numpy as np

Array = np.ndarray


class JointFriction:
    """Viscous and Coulomb friction; coefficients (n,) in N m s/rad and N m."""

    def __init__(self, viscous: Array, coulomb: Array):
        self._viscous, self._coulomb = -viscous, -coulomb
        self._slips = bool(coulomb.any())

    def torque(self, dq: Array) -> Array:
        """Return what resists velocities (n,) rad/s, (n,) N m, against their sign."""
        torque = self._viscous * dq
        if self._slips:
            torque += self._coulomb * np.sign(dq)
        return torque
