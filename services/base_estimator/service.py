"""The base estimator: sensor frames in, pose and velocity of the base out."""

import time
from typing import Any

import numpy as np

from bus import Node, Received
from bus.envelope import Envelope
from bus.rhythm import Rhythm
from bus.stream import THINNED_HZ
from estimation.base_estimator import BaseEstimate, BaseEstimator, BaseSample
from estimation.rotations import quaternion_of
from robot_model import Robot, load_robot, ports
from robot_model.messages import BaseState, SensorFrame
from services.base_estimator.config import BaseEstimatorConfig

WAIT = 0.01  # s; silence is looked at this often in lockstep, where frames wake this loop
COMPLAINT = 0.02  # s between messages while the input is silent
LONGEST_STEP = 0.05  # s; over a longer gap nothing is integrated


def main(node: Node, config: BaseEstimatorConfig) -> None:
    """Estimate one robot's base until asked to stop."""
    service = BaseService(node, load_robot(config.robot), config)
    node.ready()
    while node.running:
        service.spin()


class BaseService:
    """Moves sensor frames to the estimator, and what it finds to the port."""

    def __init__(self, node: Node, robot: Robot, config: BaseEstimatorConfig):
        self._node, self._robot, self._config = node, robot, config
        self._estimator = BaseEstimator(robot, config.support, config.settings())
        self._last: Envelope | None = None
        self._estimated = self._next = 0  # stamps, ns
        self._complained = 0.0  # s
        self._rhythm, self._found = Rhythm(1.0 / config.rate), False
        self._reason = "no sensor frame yet"
        common: dict[str, Any] = {"model": robot.model_hash, "dimensions": robot.dimensions}
        self._sensors = node.input(
            ports.service_input(robot, node.name, "sensors"),
            SensorFrame,
            source=config.inputs.get("sensors", ports.name("sensors", robot)),
            rate=ports.rate("sensors"),
            polled=not config.lockstep,
            stream="whole" if config.lockstep or config.rate > THINNED_HZ else "thinned",
            **common,
        )
        self._output = node.output(ports.name("base", robot), BaseState, config.rate, **common)
        node.verb("status", self.status, help="state of the estimate")
        node.parameters.on_change(self._configure)

    def spin(self) -> None:
        """Wait for a frame, and estimate when an estimate is due."""
        lockstep = self._config.lockstep
        self._node.wait(WAIT if lockstep else self._rhythm.rest(self._found))
        sample = self._sensors.newest()
        self._found = sample is not None
        if sample is not None:
            self._take(sample)
        if not self._sensors.fresh:
            self._complain(self._sensors.reason)

    def _take(self, sample: Received) -> None:
        envelope = sample.envelope
        repeated = self._last is not None and envelope.stamp == self._last.stamp
        if self._last is not None and envelope.stamp < self._last.stamp:
            self._estimator.reset()
            self._next = 0
        self._last = envelope
        if envelope.stamp >= self._next:
            self._estimate(sample.data, envelope)
        elif repeated and not envelope.valid:  # nothing new comes, and somebody says why
            self._complain(envelope.reason)
        self._node.acknowledge(envelope.stamp)

    def _estimate(self, frame: SensorFrame, envelope: Envelope) -> None:
        period = int(1e9 / self._config.rate)
        self._next = (envelope.stamp // period + 1) * period
        if not envelope.valid:
            self._write_nothing(envelope.reason)
            return
        dt = 1e-9 * (envelope.stamp - self._estimated)
        self._estimated = envelope.stamp
        estimate = self._estimator.step(
            self._sample(frame), dt if 0.0 < dt <= LONGEST_STEP else 0.0
        )
        self._reason = estimate.reason
        if estimate.reason:
            self._write_nothing(estimate.reason)
        else:
            self._output.write(_message(estimate), like=envelope)

    def _sample(self, frame: SensorFrame) -> BaseSample:
        quaternions = frame.imu_quat_wxyz if self._config.use_orientation else None
        if quaternions is not None and not quaternions[0].any():
            quaternions = None  # an invalid channel carries zeros
        return BaseSample(
            q=frame.q,
            dq=frame.dq,
            ft=frame.ft,
            gyro=frame.imu_gyro[0],
            acc=frame.imu_acc[0],
            quat_wxyz=None if quaternions is None else quaternions[0],
            joint_valid=frame.joint_valid,
            ft_valid=frame.ft_valid,
            imu_valid=bool(frame.imu_valid[0]),
            faults=frame.faults,
        )

    def _complain(self, reason: str) -> None:
        now = time.monotonic()
        if now - self._complained >= COMPLAINT:
            self._complained = now
            self._write_nothing(reason)

    def _write_nothing(self, reason: str) -> None:
        self._reason = reason
        upright = np.array([1.0, 0.0, 0.0, 0.0])
        nothing = BaseState(
            position=np.zeros(3),
            quat_wxyz=upright,
            twist=np.zeros(6),
            covariance=np.zeros((12, 12)),
        )
        self._output.write(nothing, like=self._last, valid=False, reason=reason)

    def _configure(self, old: BaseEstimatorConfig, new: BaseEstimatorConfig) -> None:
        fixed = ("robot", "lockstep", "inputs", "rate")
        if changed := [name for name in fixed if getattr(old, name) != getattr(new, name)]:
            raise ValueError(f"{changed[0]} cannot be changed while the service runs")
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
