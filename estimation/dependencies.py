"""Which result needs which channel, so that one lost sensor costs one limb."""

from typing import NamedTuple

import numpy as np

from estimation.oriented_graph import OrientedGraph


class Validity(NamedTuple):
    """What is valid in one sample."""

    torque: np.ndarray  # (n,) bool
    subtree: np.ndarray  # (s,) bool; of contacts too
    prediction: np.ndarray  # (k,) bool
    complete: bool
    reason: str  # names what is lost; empty when complete


class ChannelDependencies:
    """Boolean incidence between the channels of a sensor frame and the observer's results.

    A lost force/torque sensor invalidates the two sub-trees that it joins and the joint
    torques that are computed through it; a lost joint what lies beyond it as seen from
    the inertial sensor, and its own sub-tree; a lost inertial sensor everything. Another
    kinematic source has a name, and takes the first inertial sensor's place.
    """

    def __init__(self, graph: OrientedGraph, source: str | None = None):
        robot = graph.robot
        self._names = (robot.joints, robot.ft_sensors, (source or robot.imus[0],))
        self._torque_joints = graph.torque_joints()
        self._torque_sensors = graph.torque_sensors()
        self._subtree_joints = graph.subtree_joints()
        self._subtree_sensors = graph.subtree_sensors()
        self._prediction_joints = graph.prediction_joints()
        self._key: tuple[bytes, ...] = ()
        self._last: Validity

    def validity(self, joint: np.ndarray, ft: np.ndarray, imu: np.ndarray) -> Validity:
        """Return what is valid when these channels are.

        Args:
            joint, ft, imu: Validity of joints (n,), force/torque (k,) and inertial
                sensors (m,), boolean; of the last, the first counts.
        """
        key = (joint.tobytes(), ft.tobytes(), imu.tobytes())
        if key != self._key:
            self._last = self._derive(~joint, ~ft, bool(imu[0]))
            self._key = key
        return self._last

    def _derive(self, lost_joint: np.ndarray, lost_ft: np.ndarray, imu: bool) -> Validity:
        torque = self._torque_joints @ lost_joint | self._torque_sensors @ lost_ft
        subtree = self._subtree_joints @ lost_joint | self._subtree_sensors @ lost_ft
        prediction = self._prediction_joints @ lost_joint | lost_ft
        lost = (lost_joint, lost_ft, np.array([not imu]))
        names = [n for group, out in zip(self._names, lost, strict=True)
                 for n, is_out in zip(group, out, strict=True) if is_out]  # fmt: skip
        reason = "no data from " + ", ".join(names) if names else ""
        return Validity(~torque & imu, ~subtree & imu, ~prediction & imu, not names, reason)
