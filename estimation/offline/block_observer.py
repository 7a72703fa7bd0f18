"""The torque observer over many samples at once: only the recursions go one by one."""

import numpy as np
import pinocchio as pin

from estimation.offline.sensor_log import SensorBlock
from estimation.torque_observer import TorqueObserver
from estimation.wrench_balance import Balanced, WrenchBalance

Array = np.ndarray


class BlockObserver:
    """Gives the observer's numbers for blocks; every sub-tree bears one full wrench.

    Args:
        observer: Its contacts do not change between two blocks; its offsets may.
    """

    def __init__(self, observer: TorqueObserver):
        self._observer = observer
        self._size = 0

    def observe(self, block: SensorBlock) -> Balanced:
        """Return torques and wrenches of B samples."""
        if len(block) != self._size:
            self._resize(len(block))
        self._move(block)
        self._recurse()
        return self._balance.solve(block.ft - self._observer.offset)

    def _resize(self, size: int) -> None:
        graph, self._size = self._observer.graph, size
        bare = graph.bare_model
        self._q = np.tile(graph.neutral, (size, 1))
        self._v, self._a, self._tau = np.zeros((3, size, bare.nv))
        self._columns = np.zeros((size, graph.model.nv, 6))
        self._balance = WrenchBalance(graph, self._tau, self._columns)

    def _move(self, block: SensorBlock) -> None:
        tree, v, a = self._observer.graph.tree, self._v, self._a
        self._q[:, tree.joint_q] = block.q
        v[:, 3:6], v[:, tree.joint_v] = block.imu_gyro[:, 0], block.dq
        a[:, :3], a[:, 3:6] = block.imu_acc[:, 0], block.imu_dgyro[:, 0]
        a[:, tree.joint_v] = block.ddq

    def _recurse(self) -> None:
        """Fill inverse dynamics and Jacobians."""
        graph, rnea, jacobians = self._observer.graph, pin.rnea, pin.computeJointJacobians
        model, data, bare, bare_data = graph.model, graph.data, graph.bare_model, graph.bare_data
        found, columns = bare_data.tau, data.J.T
        bare_q = self._q[:, : bare.nq]  # leaves come last
        samples = zip(self._q, bare_q, self._v, self._a, self._tau, self._columns, strict=True)
        for full, q, v, a, tau, jacobian in samples:
            rnea(bare, bare_data, q, v, a)
            jacobians(model, data, full)
            tau[:], jacobian[:] = found, columns
