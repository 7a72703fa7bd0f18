"""The torque observer over a log: torques and wrenches of every sample, with their spread."""

import numpy as np

from estimation.dependencies import ChannelDependencies
from estimation.observer_covariance import ObserverNoise, propagate
from estimation.offline.block_observer import BlockObserver
from estimation.offline.sensor_log import SensorBlock
from estimation.torque_observer import TorqueObserver

Array = np.ndarray


class ObserverLog:
    """Collects what the observer finds; T samples, c contacts. Invalid entries are 0.0.

    Args:
        observer: The observer; its contacts do not change.
        noise: Standard deviations of the channels. Covariances belong to the posture in
            the middle of a block, which the caller makes short.
        size: T, number of samples of the log.
    """

    torque: Array  # (T, n) N m
    torque_std: Array  # (T, n) N m
    torque_valid: Array  # (T, n)
    wrench: Array  # (T, c, 6) about each contact's point, in the axes of its frame
    wrench_std: Array  # (T, c, 6)
    wrench_valid: Array  # (T, c)
    predicted: Array  # (T, k, 6)

    def __init__(self, observer: TorqueObserver, noise: ObserverNoise, size: int):
        self._observer, self._noise = observer, noise
        self._block_observer = BlockObserver(observer)
        self._dependencies = ChannelDependencies(observer.graph)
        self._subtrees = [contact.subtree for contact in observer.contacts]
        n, c, k = observer.robot.n, len(self._subtrees), len(observer.robot.ft_sensors)
        self.torque, self.torque_std = np.zeros((2, size, n))
        self.wrench, self.wrench_std = np.zeros((2, size, c, 6))
        self.predicted = np.zeros((size, k, 6))
        self.torque_valid = np.zeros((size, n), dtype=bool)
        self.wrench_valid = np.zeros((size, c), dtype=bool)

    def add(self, block: SensorBlock) -> None:
        """Take some samples."""
        self._observe(block)
        middle = propagate(self._observer, self._noise, *block.motion(len(block) // 2))
        self.torque_std[block.rows] = middle.torque_std
        variances = np.diagonal(middle.wrench, axis1=1, axis2=2)
        self.wrench_std[block.rows] = np.sqrt(variances)
        self._judge(block)

    def _observe(self, block: SensorBlock) -> None:
        if self._observer.shared:
            self._observe_singly(block)
            return
        found, rows = self._block_observer.observe(block), block.rows
        self.torque[rows], self.predicted[rows] = found.torque, found.predicted
        self.wrench[rows] = found.wrench[:, self._subtrees]

    def _observe_singly(self, block: SensorBlock) -> None:
        """Sub-trees with several contacts are solved posture by posture."""
        step, first = self._observer.step, block.rows.start
        gyro, acc, dgyro = block.imu_gyro[:, 0], block.imu_acc[:, 0], block.imu_dgyro[:, 0]
        samples = zip(block.q, block.dq, block.ddq, block.ft, gyro, acc, dgyro, strict=True)
        for row, sample in enumerate(samples, start=first):
            estimate = step(*sample)
            self.torque[row] = estimate.torque
            self.wrench[row] = estimate.wrench
            self.predicted[row] = estimate.predicted

    def _judge(self, block: SensorBlock) -> None:
        """Mark what is valid; flags are looked at one by one only where one is down."""
        if block.complete:
            self.torque_valid[block.rows] = self.wrench_valid[block.rows] = True
            return
        flags = zip(block.joint_valid, block.ft_valid, block.imu_valid, strict=True)
        for row, channels in enumerate(flags, start=block.rows.start):
            validity = self._dependencies.validity(*channels)
            self.torque_valid[row] = validity.torque
            self.wrench_valid[row] = validity.subtree[self._subtrees]
            self.predicted[row][~validity.prediction] = 0.0
        for values, valid in (
            (self.torque, self.torque_valid),
            (self.torque_std, self.torque_valid),
            (self.wrench, self.wrench_valid),
            (self.wrench_std, self.wrench_valid),
        ):
            values[block.rows][~valid[block.rows]] = 0.0
