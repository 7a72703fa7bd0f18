"""The base estimator: sensor frames in, pose and velocity of the base out."""

from typing import Any

import numpy as np

from bus import Node, Received
from bus.paced import PacedLoop, paced
from estimation.base_estimator import BaseEstimate, BaseEstimator, BaseSample
from estimation.rotations import quaternion_of
from robot_model import Robot, load_robot, ports
from robot_model.messages import BaseState, SensorFrame
from services.base_estimator.config import BaseEstimatorConfig

LONGEST_STEP = 0.05  # s; over a longer gap nothing is integrated


def main(node: Node, config: BaseEstimatorConfig) -> None:
    """Estimate one robot's base until asked to stop."""
    service = BaseService(node, load_robot(config.robot), config)
    node.ready()
    while node.running:
        service.loop.spin()


class BaseService:
    """Moves sensor frames to the estimator, and what it finds to the port."""

    def __init__(self, node: Node, robot: Robot, config: BaseEstimatorConfig):
        self._node, self._robot, self._config = node, robot, config
        self._estimator = BaseEstimator(robot, config.support, config.settings())
        self._estimated = 0  # stamp, ns
        self._reason = "no sensor frame yet"
        common: dict[str, Any] = {"model": robot.model_hash, "dimensions": robot.dimensions}
        sensors = node.input(
            ports.service_input(robot, node.name, "sensors"),
            SensorFrame,
            source=config.inputs.get("sensors", ports.name("sensors", robot)),
            rate=ports.rate("sensors"),
            **paced(config.rate, config.lockstep),
            **common,
        )
        self._output = node.output(ports.name("base", robot), BaseState, config.rate, **common)
        self.loop = PacedLoop(
            node,
            sensors,
            config.rate,
            config.lockstep,
            due=self._estimate,
            restart=lambda: self._estimator.reset(),
            silent=self._write_nothing,
        )
        node.verb("status", self.status, help="state of the estimate")
        node.parameters.on_change(self._configure)

    def _estimate(self, received: Received) -> None:
        frame, envelope = received.data, received.envelope
        if not envelope.valid:
            self._write_nothing(envelope.reason)
            return
        dt = 1e-9 * (envelope.stamp - self._estimated)
        self._estimated = envelope.stamp
        sample = BaseSample.of(frame, self._config.use_orientation)
        estimate = self._estimator.step(sample, dt if 0.0 < dt <= LONGEST_STEP else 0.0)
        self._reason = estimate.reason
        if estimate.reason:
            self._write_nothing(estimate.reason)
        else:
            self._output.write(_message(estimate), like=envelope)

    def _write_nothing(self, reason: str) -> None:
        self._reason = reason
        upright = np.array([1.0, 0.0, 0.0, 0.0])
        nothing = BaseState(
            position=np.zeros(3),
            quat_wxyz=upright,
            twist=np.zeros(6),
            covariance=np.zeros((12, 12)),
        )
        self._output.write(nothing, like=self.loop.last, valid=False, reason=reason)

    def _configure(self, old: BaseEstimatorConfig, new: BaseEstimatorConfig) -> None:
        old.check_change(new)
        self._estimator = BaseEstimator(self._robot, new.support, new.settings())
        self._config = new

    def status(self) -> dict[str, Any]:
        """Return the state of service and estimate."""
        return {**self._node.status(), "support": self._config.support, "reason": self._reason}


def _message(estimate: BaseEstimate) -> BaseState:
    return BaseState(
        position=estimate.position,
        quat_wxyz=quaternion_of(estimate.rotation),
        twist=estimate.twist,
        covariance=estimate.covariance,
    )
