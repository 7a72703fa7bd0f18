"""Joint torques that hold a resting robot against gravity (Fumagalli, section 6.3.3).

Beyond the thesis, whose robot hangs on a fixed base: on the floor the supports' wrenches
are part of the balance, tau = g(q) - sum of J' w over the supports.
"""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from estimation.support_wrenches import share_support, sole_box
from robot_model import Robot

LOCAL = pin.ReferenceFrame.LOCAL


class GravityResult(NamedTuple):
    """Torques that hold the robot, and how."""

    torque: np.ndarray  # (n,) N m
    support_wrench: np.ndarray  # (s, 6) of the world on the supports, in their frames
    reason: str  # why it is invalid; empty when it is valid


class LoadSharing:
    """Low-passed share of each support in the vertical load; even while it is not known."""

    def __init__(self, count: int, time_constant: float):
        self._even = np.full(count, 1.0 / max(1, count))
        self.shares = self._even
        self._time_constant = time_constant  # s

    def update(self, vertical: np.ndarray | None, dt: float) -> np.ndarray:
        """Return the shares (s,) after vertical forces (s,) [N], None while unknown."""
        target = self._even
        if vertical is not None:
            pressing = np.maximum(vertical, 0.0)
            if (total := float(pressing.sum())) > 1.0:
                target = pressing / total
        pull = dt / (self._time_constant + dt)
        self.shares = self.shares + pull * (target - self.shares)
        return self.shares


class GravityCompensator:
    """Gravity torques of a robot on its supports.

    Args:
        robot: The robot.
        support: Kind of support, a key of ``robot.supports``.
        time_constant: Of the load sharing [s].

    Raises:
        LookupError: The robot has no such support.
    """

    def __init__(self, robot: Robot, support: str, time_constant: float):
        self._robot = robot
        self._tree = robot.tree
        self._data = self._tree.model.createData()
        self._time_constant = time_constant
        self._q = self._tree.neutral.copy()
        self.set_support(support)

    def set_support(self, support: str) -> None:
        """Use another kind of support from now on."""
        if support not in self._robot.supports:
            exist = ", ".join(self._robot.supports)
            raise LookupError(f"no support '{support}'; there are: {exist}")
        self.supports = self._robot.supports[support]
        self._frames = [self._tree.frame_id(name) for name in self.supports]
        self._boxes = [sole_box(self._robot.soles.get(name)) for name in self.supports]
        self.reset()

    @property
    def shares(self) -> np.ndarray:
        """Present share (s,) of each support in the load."""
        return self._sharing.shares

    def reset(self) -> None:
        """Forget how the load was shared."""
        self._sharing = LoadSharing(len(self.supports), self._time_constant)

    def step(
        self, q: np.ndarray, rotation: np.ndarray, force: np.ndarray | None, dt: float
    ) -> GravityResult:
        """Return the torques at a posture.

        Args:
            q: Joint positions, (n,) rad.
            rotation: R_world_base (3, 3).
            force: Measured force of the world on each support, (s, 3) N in its frame;
                None while it is not known.
            dt: Time since the last call [s].
        """
        model, data, tree = self._tree.model, self._data, self._tree
        if not self._frames:
            return GravityResult(np.zeros(self._robot.n), np.zeros((0, 6)), "no support")
        self._q[3:7] = pin.Quaternion(rotation).coeffs()
        self._q[tree.joint_q] = q
        gravity = pin.computeGeneralizedGravity(model, data, self._q)
        jacobians = [pin.computeFrameJacobian(model, data, self._q, f, LOCAL) for f in self._frames]
        effect = np.concatenate(jacobians).T  # of the supports' wrenches on base and joints
        vertical = None if force is None else _vertical(rotation[2] @ effect[:3], force)
        shares = self._sharing.update(vertical, dt)
        result = share_support(effect[:6], gravity[:6], shares, self._boxes)
        torque = (gravity - effect @ result.wrench.ravel())[tree.joint_v]
        reason = "" if result.feasible else "the centre of mass lies outside the supports"
        return GravityResult(torque, result.wrench, reason)


def _vertical(lift: np.ndarray, force: np.ndarray) -> np.ndarray:
    """Upward part (s,) of forces (s, 3), given the upward part of unit wrenches (6 s,)."""
    return (lift.reshape(-1, 6)[:, :3] * force).sum(axis=1)
