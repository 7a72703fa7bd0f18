"""The gravity compensator: posture, attitude and loads in, feed-forward torques out."""

from typing import Any

import numpy as np

from bus import Input, Node, Received
from bus.envelope import Envelope
from bus.lockstep import Join
from bus.paced import PacedLoop, paced
from estimation.gravity import GravityCompensator
from estimation.rotations import rotation_of
from robot_model import Robot, load_robot, ports
from robot_model.messages import BaseState, ExternalWrenches, GravityTorques, SensorFrame
from services.gravity_compensator.config import GravityCompensatorConfig

LONGEST_STEP = 0.1  # s; the load sharing moves no further over a longer gap


def main(node: Node, config: GravityCompensatorConfig) -> None:
    """Compensate one robot's gravity until asked to stop."""
    service = GravityService(node, load_robot(config.robot), config)
    node.ready()
    while node.running:
        service.loop.spin()


class GravityService:
    """Moves samples to the compensator, and its torques to the port."""

    def __init__(self, node: Node, robot: Robot, config: GravityCompensatorConfig):
        self._node, self._robot, self._config = node, robot, config
        self._compensator = GravityCompensator(robot, config.support, config.sharing_time)
        self._done = 0  # stamp, ns
        self._reason = "no sensor frame yet"
        sensors = self._input("sensors", SensorFrame)
        self._base = self._input("base", BaseState)
        self._wrenches = self._input("wrenches", ExternalWrenches)
        self._join = Join(node, [self._base, self._wrenches])
        self._output = node.output(
            ports.name("gravity", robot),
            GravityTorques,
            rate=config.rate,
            model=robot.model_hash,
            dimensions=robot.dimensions,
        )
        self.loop = PacedLoop(
            node,
            sensors,
            config.rate,
            config.lockstep,
            due=self._compensate,
            restart=lambda: self._compensator.reset(),
            silent=self._write_nothing,
        )
        node.verb("status", self.status, help="state, shares of the load")
        node.parameters.on_change(self._configure)

    def _input(self, key: str, kind: type) -> Input:
        robot, config = self._robot, self._config
        return self._node.input(
            ports.service_input(robot, self._node.name, key),
            kind,
            source=config.inputs.get(key, ports.name(key, robot)),
            rate=ports.rate(key),
            model=robot.model_hash if kind is not BaseState else "",
            dimensions={**robot.dimensions, "s": len(robot.subtrees)},
            **paced(config.rate, config.lockstep),
        )

    def _compensate(self, received: Received) -> None:
        frame, envelope = received.data, received.envelope
        self._join.wait(envelope.stamp)
        if reason := self._obstacle(frame, envelope):
            self._write_nothing(reason)
            return
        dt = min(LONGEST_STEP, 1e-9 * max(0, envelope.stamp - self._done))
        self._done = envelope.stamp
        rotation = rotation_of(self._base.latest.data.quat_wxyz)  # type: ignore[union-attr]
        result = self._compensator.step(frame.q, rotation, self._support_force(), dt)
        if result.reason:
            self._write_nothing(result.reason)
            return
        self._reason = ""
        self._output.write(GravityTorques(torque=result.torque), like=envelope)

    def _obstacle(self, frame: SensorFrame, envelope: Envelope) -> str:
        """Say why there can be no torques now."""
        if not envelope.valid:
            return envelope.reason
        if not frame.joint_valid.all():
            return f"no data from {self._robot.joints[int(frame.joint_valid.argmin())]}"
        base = self._base.latest
        if base is None or not self._base.fresh:
            return self._base.reason or "no base estimate yet"
        return "" if base.envelope.valid else f"base: {base.envelope.reason}"

    def _support_force(self) -> np.ndarray | None:
        """Measured forces (s, 3) on the supports in their frames; None while unknown."""
        latest = self._wrenches.latest
        if latest is None or not latest.envelope.valid or not self._wrenches.fresh:
            return None
        data = latest.data
        rows = [self._row(data, frame) for frame in self._compensator.supports]
        return None if -1 in rows else data.wrench[rows, :3]

    @staticmethod
    def _row(data: ExternalWrenches, frame: str) -> int:
        """Row of a support's wrench, -1 when it is not valid."""
        for i, (name, kind) in enumerate(zip(data.frame, data.kind, strict=True)):
            if name == frame and kind == "support" and data.valid[i] and _decided(data, i):
                return i
        return -1

    def _write_nothing(self, reason: str) -> None:
        self._reason = reason
        nothing = GravityTorques(torque=np.zeros(self._robot.n))
        self._output.write(nothing, like=self.loop.last, valid=False, reason=reason)

    def _configure(self, old: GravityCompensatorConfig, new: GravityCompensatorConfig) -> None:
        old.check_change(new)
        self._compensator = GravityCompensator(self._robot, new.support, new.sharing_time)
        self._config = new

    def status(self) -> dict[str, Any]:
        """Return the state of the service and how the supports share the load."""
        shares = zip(self._compensator.supports, self._compensator.shares.tolist(), strict=True)
        return {
            **self._node.status(),
            "support": self._config.support,
            "shares": dict(shares),
            "reason": self._reason,
        }


def _decided(data: ExternalWrenches, row: int) -> bool:
    """Whether the sensors decide a wrench; they do where the message does not say."""
    return not data.decided or data.decided[row]
