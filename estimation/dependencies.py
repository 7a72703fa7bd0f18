"""Which result needs which channel, so that one lost sensor costs one limb."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from estimation.oriented_graph import OrientedGraph
from estimation.saturation import faults_by_name


class Validity(NamedTuple):
    """What is valid in one sample."""

    torque: np.ndarray  # (n,) bool
    subtree: np.ndarray  # (s,) bool; of contacts too
    prediction: np.ndarray  # (k,) bool
    complete: bool
    reason: str  # names what is lost; empty when complete
    torque_reasons: list[str] = []  # per joint; all three are empty when complete
    subtree_reasons: list[str] = []
    prediction_reasons: list[str] = []


class ChannelDependencies:
    """Boolean incidence between the channels of a sensor frame and the observer's results.

    A lost force/torque sensor invalidates the two sub-trees that it joins and the joint
    torques that are computed through it; a lost joint what lies beyond it as seen from
    the inertial sensor, and its own sub-tree; a lost inertial sensor everything. Another
    kinematic source has a name, and takes the first inertial sensor's place.
    """

    def __init__(self, graph: OrientedGraph, source: str | None = None):
        robot = graph.robot
        self._names = (*robot.joints, *robot.ft_sensors, source or robot.imus[0])
        own = np.eye(len(robot.ft_sensors), dtype=bool)
        self._torque_needs = _with_imu(graph.torque_joints(), graph.torque_sensors())
        self._subtree_needs = _with_imu(graph.subtree_joints(), graph.subtree_sensors())
        self._prediction_needs = _with_imu(graph.prediction_joints(), own)
        self._key: tuple[object, ...] = ()
        self._last: Validity

    def validity(
        self, joint: np.ndarray, ft: np.ndarray, imu: np.ndarray, faults: Sequence[str] = ()
    ) -> Validity:
        """Return what is valid when these channels are.

        Args:
            joint, ft, imu: Validity of joints (n,), force/torque (k,) and inertial
                sensors (m,), boolean; of the last, the first counts.
            faults: Of the sensor frame: why a sensor is invalid, ``name: why``.
        """
        key = (joint.tobytes(), ft.tobytes(), imu.tobytes(), tuple(faults))
        if key != self._key:
            self._last = self._derive(~joint, ~ft, ~imu[:1], faults_by_name(faults))
            self._key = key
        return self._last

    def _derive(
        self, lost_joint: np.ndarray, lost_ft: np.ndarray, lost_imu: np.ndarray, why: dict[str, str]
    ) -> Validity:
        lost = np.concatenate((lost_joint, lost_ft, lost_imu))
        needs = (self._torque_needs, self._subtree_needs, self._prediction_needs)
        torque, subtree, prediction = (~(rows @ lost) for rows in needs)
        if not lost.any():
            return Validity(torque, subtree, prediction, True, "")
        reasons = [[self._reason(row & lost, why) for row in rows] for rows in needs]
        return Validity(torque, subtree, prediction, False, self._reason(lost, why), *reasons)

    def _reason(self, lost: np.ndarray, why: dict[str, str]) -> str:
        names = [name for name, is_lost in zip(self._names, lost, strict=True) if is_lost]
        silent = [name for name in names if name not in why]
        reasons = [f"{name} is {why[name]}" for name in names if name in why]
        return "; ".join((["no data from " + ", ".join(silent)] if silent else []) + reasons)


def _with_imu(joints: np.ndarray, sensors: np.ndarray) -> np.ndarray:
    """Which channels each result needs, (results, n + k + 1): all need the inertial sensor."""
    return np.hstack((joints, sensors, np.ones((len(joints), 1), dtype=bool)))
