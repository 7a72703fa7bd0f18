"""From predicted and measured readings to external wrenches and joint torques.

The same for one posture and for many: leading dimensions are those of the samples.
"""

from typing import NamedTuple

import numpy as np

from estimation.oriented_graph import OrientedGraph

Array = np.ndarray


class Balanced(NamedTuple):
    """What the balance tells, s sub-trees; wrenches are of the world on the robot."""

    torque: Array  # (…, n) link torques, were every net wrench to act at its leaf
    wrench: Array  # (…, s, 6) net, about the leaves, in their axes
    external_imu: Array  # (…, s, 6) net, about the root, in its axes
    predicted: Array  # (…, k, 6)


class WrenchBalance:
    """Solves F eqs. (4.2.1) and (4.3) with constant incidence matrices.

    Reads the inverse dynamics and the Jacobians of an ``OrientedGraph`` from arrays that
    the caller fills: ``tau`` (…, nv) without the leaves, and ``columns`` (…, nv + 6 s, 6),
    each a motion [v w] in the root's axes.
    """

    def __init__(self, graph: OrientedGraph, tau: Array, columns: Array):
        s, many = len(graph.incidence), tau.shape[:-1]
        self._graph, self._incidence = graph, graph.incidence
        self._tau, self._joint_v = tau, graph.tree.joint_v
        self._jacobian = columns.reshape(*many, -1)
        if not np.shares_memory(self._jacobian, columns):
            raise RuntimeError("the Jacobian is not column-major; cannot take a view")
        self._sign = graph.tree.cut_sign[:, None]
        self._mirrored = bool((graph.tree.cut_sign < 0.0).any())
        self._index()
        self._entering = np.zeros((*many, s, 6))
        self._through = self._entering[..., 1:, :]
        self._gathered = np.zeros((*many, self._jacobian_index.size))
        self._force_maps = self._gathered[..., : 36 * s].reshape(*many, s, 6, 6)
        self.joint_axes = self._gathered[..., 36 * s :].reshape(*many, -1, 6)
        leaves = columns[..., graph.leaf_v : graph.leaf_v + 6 * s, :]
        self._leaf_maps = leaves.reshape(*many, s, 6, 6)

    def _index(self) -> None:
        """Lay out what is gathered from tau and from the Jacobian at each step.

        A column block of J is a motion map X = [R [p]R; 0 R]; the force map [R 0; [p]R R]
        has the same blocks in other places. The transpose of a leaf's block maps forces
        back to the leaf.
        """
        entering_v = np.vstack([np.arange(6), self._graph.tree.cut_v])
        swap = np.array([3, 4, 5, 0, 1, 2])
        force_index = 6 * entering_v[:, None, swap] + swap[None, :, None]
        joint_index = 6 * self._joint_v[:, None] + np.arange(6)
        self._tau_index = entering_v
        self._jacobian_index = np.concatenate([force_index.ravel(), joint_index.ravel()])

    def solve(self, measured: Array) -> Balanced:
        """Return wrenches and torques from readings (…, k, 6) without their offsets."""
        through = self._through
        self._tau.take(self._tau_index, axis=-1, out=self._entering, mode="clip")
        self._jacobian.take(self._jacobian_index, axis=-1, out=self._gathered, mode="clip")
        predicted = through.copy()
        through -= measured
        if self._mirrored:
            # Where the model's parent is the child of the sensor, both signs turn.
            predicted *= self._sign
            np.multiply(predicted - measured, self._sign, out=through)
        entering_imu = np.matvec(self._force_maps, self._entering)
        external_imu = self._incidence @ entering_imu
        below = self._graph.contact_below @ external_imu
        torque = self._tau.take(self._joint_v, axis=-1) - np.vecdot(self.joint_axes, below)
        return Balanced(torque, np.matvec(self._leaf_maps, external_imu), external_imu, predicted)
