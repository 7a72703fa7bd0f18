"""Virtual joint torque sensors and external wrenches from force/torque sensors.

One recursive Newton-Euler pass over the Enhanced Oriented Graph predicts every
force/torque reading; what the sensors read otherwise is the external wrench of the
sub-trees, and the joint torques follow (Fumagalli, sections 3.3-3.4 and 4.3). Several
contacts of a sub-tree share its wrench (Nori et al., section 3.2.1).
"""

from collections.abc import Iterable
from dataclasses import dataclass, replace

import numpy as np
import pinocchio as pin

from estimation.contact_set import AnyTouch, Contact, contact_set, net_contacts, shared_subtrees
from estimation.contact_wrenches import ContactWrenches
from estimation.oriented_graph import OrientedGraph
from estimation.shared_contacts import Decision, SharedSubtree, decision
from estimation.wrench_balance import WrenchBalance
from robot_model import Robot


@dataclass(frozen=True, eq=False, slots=True)
class Estimate:
    """What one sample tells. Wrenches are [f m] of the world on the robot, N and N m."""

    torque: np.ndarray  # (n,) link torques, N m
    wrench: np.ndarray  # (c, 6) about each contact's point, in the axes of its frame
    subtree_wrench: np.ndarray  # (s, 6) net, about each sub-tree's default frame
    predicted: np.ndarray  # (k, 6) readings if nothing touched the side away from the IMU
    measured: np.ndarray  # (k, 6) readings without their offsets
    unexplained: np.ndarray | None = None  # (s, 6) as subtree_wrench: by no contact; None: zero
    decision: Decision | None = None  # None: each sub-tree bears one full wrench


class TorqueObserver:
    """Torques of all joints and the external wrenches on k + 1 sub-trees, k sensors.

    Needs neither attitude nor base velocity: the accelerometer carries gravity. The
    net wrench of a sub-tree acts at its contact, or is shared among its ``contacts``; it
    does not depend on where they are.
    """

    contacts: tuple[Contact, ...]
    shared: list[SharedSubtree]  # those that bear other than one full wrench
    lone_rows: list[int]  # contacts on the others ...
    lone_subtrees: list[int]  # ... and their sub-trees

    def __init__(self, robot: Robot, support: str = "floor"):
        self.robot = robot
        self.support = support
        self.offset = np.zeros((len(robot.ft_sensors), 6))  # reading minus true wrench
        self.contacts = contact_set(robot, support)
        self.graph = OrientedGraph(robot, self.contacts)
        self._bind()
        self._combine()

    def set_contacts(self, touches: Iterable[AnyTouch] = (), support: str | None = None) -> None:
        """Say where the world acts from the next sample on.

        Args:
            touches: Links (or frames), points (3,) in them [m], and what is known of the
                wrench there; they replace the default contact of their sub-trees.
            support: New kind of support; unchanged when None.

        Raises:
            LookupError, ValueError: As ``contact_set``; nothing has changed then.
        """
        support = self.support if support is None else support
        self.contacts = contact_set(self.robot, support, touches)
        self.support = support
        self.graph.place(self.contacts)
        self._combine()

    def step(
        self,
        q: np.ndarray,
        dq: np.ndarray,
        ddq: np.ndarray,
        ft: np.ndarray,
        gyro: np.ndarray,
        acc: np.ndarray,
        dgyro: np.ndarray,
    ) -> Estimate:
        """Return torques and wrenches of one instant.

        Args:
            q, dq, ddq: Joint motion, (n,) rad, rad/s, rad/s^2.
            ft: Readings, (k, 6) parent on child, in the sensors' frames.
            gyro, acc, dgyro: Angular velocity, proper and angular acceleration of the
                first inertial sensor, (3,) in its frame.
        """
        motion = self.motion(q, dq, ddq, gyro, acc, dgyro)
        pin.rnea(self._bare, self._bare_data, *motion)
        pin.computeJointJacobians(self._model, self._data, self._q)
        return self._balance(ft - self.offset)

    def motion(
        self,
        q: np.ndarray,
        dq: np.ndarray,
        ddq: np.ndarray,
        gyro: np.ndarray,
        acc: np.ndarray,
        dgyro: np.ndarray,
    ) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return configuration, velocity and acceleration of the model without leaves.

        Valid until the next call; arguments as those of ``step``.
        """
        self._q[self._joint_q] = q
        v, a, joint_v = self._v, self._a, self._joint_v
        v[3:6] = gyro
        v[joint_v] = dq
        a[:3] = acc
        a[3:6] = dgyro
        a[joint_v] = ddq
        return self._bare_q, v, a

    def _balance(self, measured: np.ndarray) -> Estimate:
        """Turn predicted and measured readings into external wrenches and torques."""
        found = self._wrenches.solve(measured)
        subtree_wrench = self._about_default_frames(found.wrench, found.external_imu)
        estimate = Estimate(found.torque, found.wrench, subtree_wrench, found.predicted, measured)
        return self._share(estimate, found.external_imu) if self.shared else estimate

    def _share(self, net: Estimate, external_imu: np.ndarray) -> Estimate:
        """Share the net wrench of some sub-trees among their contacts."""
        wrench, torque = np.zeros((len(self.contacts), 6)), net.torque.copy()
        wrench[self.lone_rows] = net.wrench[self.lone_subtrees]
        unexplained = np.zeros_like(external_imu)
        solved = [subtree.at(self._data) for subtree in self.shared]
        for subtree, shares in zip(self.shared, solved, strict=True):
            external = external_imu[subtree.row]
            result = shares.solution.solve(external)
            wrench[subtree.rows] = result.wrench
            torque -= np.vecdot(self._wrenches.joint_axes, shares.moved(result.wrench, external))
            if shares.solution.rank < 6:
                left = subtree.about_default_frame(result.residual, self._data)
                unexplained[subtree.row] = left
        decided = self._decision or self._decide([shares.solution for shares in solved])
        return replace(net, torque=torque, wrench=wrench, unexplained=unexplained, decision=decided)

    def _decide(self, solved: list[ContactWrenches]) -> Decision:
        return decision(len(self.robot.subtrees), len(self.contacts), self.shared, solved)

    def _about_default_frames(self, wrench: np.ndarray, external_imu: np.ndarray) -> np.ndarray:
        """Shift the wrenches of those sub-trees whose contact is not at the default frame."""
        if not self.moved:
            return wrench
        shifted = wrench.copy()
        for row, joint, joint_m_frame in self.moved:
            imu_m_frame = self._data.oMi[joint] * joint_m_frame
            shifted[row] = imu_m_frame.actInv(pin.Force(external_imu[row])).vector
        return shifted

    def _bind(self) -> None:
        """Take views of Pinocchio's results, which stay where they are in memory."""
        tree, self._model = self.graph.tree, self.graph.model
        self._bare = self.graph.bare_model
        self._data, self._bare_data = self.graph.data, self.graph.bare_data
        self._q = self.graph.neutral.copy()
        self._bare_q = self._q[: self._bare.nq]  # leaves come last
        self._v, self._a = np.zeros(self._bare.nv), np.zeros(self._bare.nv)
        self._joint_q, self._joint_v = tree.joint_q, tree.joint_v
        # row = column of J, a motion [v w] in IMU axes
        self._wrenches = WrenchBalance(self.graph, self._bare_data.tau, self._data.J.T)

    def _combine(self) -> None:
        """Recompute what depends on the contacts."""
        nets = net_contacts(self.robot, self.contacts)
        self.moved = [
            (i, *self.graph.locate(*self.robot.frame(subtree.default_frame)))
            for i, (subtree, contact) in enumerate(zip(self.robot.subtrees, nets, strict=True))
            if contact.frame != subtree.default_frame or contact.kind == "touch"
        ]
        shared = shared_subtrees(self.robot, self.contacts)
        subtrees = [contact.subtree for contact in self.contacts]
        self.shared = [
            SharedSubtree(self.graph, row, some, subtrees.index(row) if some else 0)
            for row, some in shared.items()
        ]
        rigid = [subtree.rigid for subtree in self.shared if subtree.rigid is not None]
        self._decision = self._decide(rigid) if len(rigid) == len(self.shared) else None
        self.lone_rows = [i for i, row in enumerate(subtrees) if row not in shared]
        self.lone_subtrees = [subtrees[i] for i in self.lone_rows]
