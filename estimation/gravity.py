"""Joint torques that hold a resting robot against gravity (Fumagalli, section 6.3.3).

Beyond the thesis, whose robot hangs on a fixed base: on the floor the supports' wrenches
are part of the balance, tau = g(q) - sum of J' w over the supports.
"""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from estimation.support_wrenches import share_support, sole_box
from robot_model import Robot


class GravityResult(NamedTuple):
    """Torques that hold the robot, and how."""

    torque: np.ndarray  # (n,) N m
    support_wrench: np.ndarray  # (s, 6) of the world on the supports, in their frames
    reason: str  # why it is invalid; empty when it is valid


class LoadSharing:
    """Low-passed share of each support in the vertical load; even while it is not known."""

    def __init__(self, count: int, time_constant: float):
        self.shares = np.full(count, 1.0 / max(1, count))
        self._time_constant = time_constant  # s

    def update(self, vertical: np.ndarray | None, dt: float) -> np.ndarray:
        """Return the shares (s,) after vertical forces (s,) [N], None while unknown."""
        count = len(self.shares)
        target = np.full(count, 1.0 / max(1, count))
        if vertical is not None and (total := float(np.maximum(vertical, 0.0).sum())) > 1.0:
            target = np.maximum(vertical, 0.0) / total
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
        pin.computeJointJacobians(model, data, self._q)
        jacobians = np.array([self._jacobian(frame) for frame in self._frames])
        vertical = None if force is None else self._vertical(force)
        shares = self._sharing.update(vertical, dt)
        maps = jacobians[:, :, :6].transpose(0, 2, 1)
        result = share_support(maps, gravity[:6], shares, self._boxes)
        joints = jacobians[:, :, tree.joint_v]
        torque = gravity[tree.joint_v] - np.einsum("sij,si->j", joints, result.wrench)
        reason = "" if result.feasible else "the centre of mass lies outside the supports"
        return GravityResult(torque, result.wrench, reason)

    def _jacobian(self, frame: int) -> np.ndarray:
        local = pin.ReferenceFrame.LOCAL
        pin.updateFramePlacement(self._tree.model, self._data, frame)
        return pin.getFrameJacobian(self._tree.model, self._data, frame, local).copy()

    def _vertical(self, force: np.ndarray) -> np.ndarray:
        """Upward part (s,) of forces in support axes; placements are those of the last call."""
        placements = [self._data.oMf[frame].rotation[2] for frame in self._frames]
        return np.einsum("si,si->s", np.array(placements), force)
