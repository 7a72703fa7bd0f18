"""What the torque observer writes."""

from typing import Any

import numpy as np

from bus import Node, Output
from bus.envelope import Envelope
from estimation.dependencies import Validity
from estimation.observer_covariance import Uncertainty
from estimation.torque_observer import Estimate, TorqueObserver
from robot_model import Robot, ports
from robot_model.messages import ExternalWrenches, FtPrediction, JointTorques
from services.torque_observer.messages import Composer

KINDS = {"torques": JointTorques, "wrenches": ExternalWrenches, "ft_prediction": FtPrediction}


class Outputs:
    """The ports of torques, wrenches and predicted readings."""

    def __init__(self, node: Node, observer: TorqueObserver):
        self._observer, self._robot = observer, observer.robot
        robot = observer.robot
        sizes = {**robot.dimensions, "s": len(robot.subtrees)}
        common: dict[str, Any] = {"model": robot.model_hash, "dimensions": sizes}
        self._torques, self._wrenches, self._predictions = (
            node.output(ports.name(key, robot), kind, rate=ports.rate(key), **common)
            for key, kind in KINDS.items()
        )
        self._composer = Composer(observer)
        self.prepare()

    def prepare(self) -> None:
        """Take the observer's contacts."""
        self._composer.prepare()
        self._nothing = self._observer.step(*still(self._robot))

    def write(
        self, estimate: Estimate, uncertainty: Uncertainty, validity: Validity, like: Envelope
    ) -> None:
        """Write torques, and what costs more only where somebody listens."""
        torques = self._composer.torques(estimate, uncertainty, validity)
        if validity.complete:
            self._torques.write(torques, like=like)
        else:
            _judge(self._torques, torques, validity.torque, validity, like)
        if self._wrenches.wanted(like.stamp):
            wrenches = self._composer.wrenches(estimate, uncertainty, validity)
            _judge(self._wrenches, wrenches, validity.subtree, validity, like)
        if self._predictions.wanted(like.stamp):
            prediction = self._composer.prediction(estimate, uncertainty, validity)
            _judge(self._predictions, prediction, validity.prediction, validity, like)

    def write_nothing(self, uncertainty: Uncertainty, reason: str, like: Envelope | None) -> None:
        """Write everything as invalid."""
        lost, nothing = _lost(self._robot, reason), self._nothing
        for output, data in (
            (self._torques, self._composer.torques(nothing, uncertainty, lost)),
            (self._wrenches, self._composer.wrenches(nothing, uncertainty, lost)),
            (self._predictions, self._composer.prediction(nothing, uncertainty, lost)),
        ):
            output.write(data, like=like, valid=False, reason=reason)


def _judge(output: Output, data: Any, valid: np.ndarray, validity: Validity, like: Any) -> None:
    """A message with at least one valid entry is valid; its flags tell which."""
    whole = validity.complete or bool(valid.any())
    output.write(data, like=like, valid=whole, reason="" if whole else validity.reason)


def _lost(robot: Robot, reason: str) -> Validity:
    torque, subtree, prediction = (
        np.zeros(size, dtype=bool) for size in (robot.n, len(robot.subtrees), len(robot.ft_sensors))
    )
    return Validity(torque, subtree, prediction, False, reason)


def still(robot: Robot) -> tuple[np.ndarray, ...]:
    """Arguments of an observer step at home posture, whose results are never shown."""
    n, k = robot.n, len(robot.ft_sensors)
    return robot.home, np.zeros(n), np.zeros(n), np.zeros((k, 6)), *np.zeros((3, 3))
