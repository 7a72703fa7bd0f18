"""The simulated robot as a driver: raw frames and motor commands over the bus."""

import time

from bus import Node
from robot_model import Robot, ports
from robot_model.messages import MotorCommand, RawFrame
from services.sensor_server.config import SensorServerConfig
from services.sensor_server.driver import FtConvention, Reading

DEPTH = 64  # frames; a plant that catches up sends bursts, and none may be lost


class PlantDriver:
    """Reads ``/<robot>/raw:o`` and writes ``/<robot>/motor_command:o``."""

    ft_convention: FtConvention = "wrenchbus"
    checked = True  # by the bus, which refuses other messages

    def __init__(self, node: Node, robot: Robot, config: SensorServerConfig):
        self._node = node
        self._robot = robot
        self._config = config

    def open(self) -> None:
        """Open the two ports; the plant may appear later."""
        robot, config = self._robot, self._config
        types = {"model": robot.model_hash, "dimensions": robot.dimensions}
        self._raw = self._node.input(
            ports.service_input(robot, "sensor_server", "raw"),
            RawFrame,
            source=config.inputs.get("raw", ports.name("raw", robot)),
            depth=DEPTH,
            rate=config.rate,
            **types,
        )
        self._commands = self._node.output(
            ports.name("motor_command", robot), MotorCommand, rate=config.command.rate, **types
        )

    def read(self, timeout: float) -> Reading | None:
        """Return the next raw frame, waiting on the bus for at most ``timeout`` [s]."""
        deadline = time.monotonic() + timeout
        while (received := self._raw.read()) is None:
            remaining = deadline - time.monotonic()
            if remaining <= 0.0:
                return None
            self._node.wait(remaining)
        envelope = received.envelope
        return Reading(
            received.data,
            envelope.stamp,
            envelope.clock,
            envelope.acquired,
            envelope.valid,
            envelope.reason,
        )

    @property
    def silence(self) -> str:
        return self._raw.reason

    @property
    def paused(self) -> bool:
        return self._node.clock.paused_at > 0

    def write(self, command: MotorCommand, reading: Reading) -> None:
        """Send a command to the plant's boards."""
        self._commands.write(
            command, stamp=reading.stamp, clock=reading.clock, acquired=reading.acquired
        )

    def close(self) -> None:
        """Nothing to do: the node closes its ports."""
