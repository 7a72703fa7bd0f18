"""The classical residual of a robot whose base is held still (R eq. 7)."""

import numpy as np
import pinocchio as pin

from estimation.joint_friction import JointFriction
from estimation.residual.momentum_filter import MomentumFilter
from robot_model import Robot

Array = np.ndarray
GRAVITY = 9.81  # m/s^2


class FixedBaseResidual:
    """Joint torques of touches on a robot that hangs on a pole.

    Nobody measures what the pole exerts, so neither the internal nor the external
    residual exists; the joints of a fixed base do not feel the pole. The momentum holds
    the rotors; viscous and Coulomb friction are taken from the motors' torques.

    Args:
        robot: The robot, held by its base link.
        gain: 1/s, scalar or (n,).
    """

    def __init__(self, robot: Robot, gain: float | Array = 25.0):
        self.robot = robot
        tree = robot.tree
        self._model = pin.Model(tree.model)
        self._data = self._model.createData()
        self._q, self._v = pin.neutral(self._model), np.zeros(self._model.nv)
        self._joint_q, self._joint_v = tree.joint_q, tree.joint_v
        self._friction = JointFriction(robot.viscous, robot.coulomb)
        self._filter = MomentumFilter(robot.n, gain)

    def set_gain(self, gain: float | Array) -> None:
        """Set the gain [1/s], scalar or (n,)."""
        self._filter.gain = gain

    def reset(self) -> None:
        """Start again from zero with the next sample."""
        self._filter.reset()

    @property
    def residual(self) -> Array:
        """Residual after the last step, (n,) N m."""
        return self._filter.residual

    def step(
        self, q: Array, dq: Array, motor_torque: Array, up_base: Array, period: float
    ) -> Array:
        """Take one sample and return the residual, (n,) N m.

        Args:
            q, dq, motor_torque: (n,) rad, rad/s, N m.
            up_base: Direction away from the earth's centre, (3,) in base axes, of length one.
            period: Time since the last sample [s].
        """
        model, data, rows = self._model, self._data, self._joint_v
        self._q[self._joint_q] = q
        self._v[rows] = dq
        model.gravity.linear = -GRAVITY * up_base
        mass = pin.crba(model, data, self._q)
        coriolis = pin.computeCoriolisMatrix(model, data, self._q, self._v)
        gravity = pin.computeGeneralizedGravity(model, data, self._q)
        momentum = (mass @ self._v)[rows] + self.robot.rotor_inertia @ dq
        rate = (self._v @ coriolis - gravity)[rows] + motor_torque + self._friction.torque(dq)
        return self._filter.step(momentum, rate, period)
