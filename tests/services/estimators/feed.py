"""Sensor frames of a plant in this process, fed to a service in another."""

import time
from collections.abc import Callable
from dataclasses import fields
from typing import Any, TypeVar

from bus import Input, Node
from robot_model import messages, ports
from robot_model.messages import RawFrame, SensorFrame
from robot_sim import Plant

T = TypeVar("T")


class Feed:
    """Writes the plant's frames onto a service's input, and reads what the service says."""

    def __init__(self, node: Node, plant: Plant, service: str):
        self.node, self.plant, self.robot = node, plant, plant.robot
        self._common = {"model": self.robot.model_hash, "dimensions": self.robot.dimensions}
        self._frames = self.writer(ports.service_input(self.robot, service, "sensors"), SensorFrame)
        self.changes: dict[str, Any] = {}

    def writer(self, name: str, kind: type) -> Any:
        """Return a direct writer onto an input."""
        return self.node.output(name, kind, **self._common)

    def listen(self, key: str) -> Input:
        """Return an input of the test's on one of the robot's ports."""
        kind = getattr(messages, ports.port(key).message)
        source = ports.name(key, self.robot)
        return self.node.input(f"/test/{key}:i", kind, source, depth=64, **self._common)

    def step(self) -> None:
        """Let one millisecond pass in the plant and write its frame."""
        self.plant.step()
        self.write()

    def write(self, **more: Any) -> None:
        """Write the frame of the present instant."""
        frame = sensor_frame(self.plant.raw(), self.changes)
        self._frames.write(frame, stamp=self.plant.time, clock=1, **more)

    def until(self, predicate: Callable[[], T | None], timeout: float = 60.0) -> T:
        """Feed until a predicate holds; return its value."""
        deadline = time.monotonic() + timeout
        while not (value := predicate()):
            assert time.monotonic() < deadline, f"not within {timeout} s"
            self.step()
            self.node.wait(0.001)
        return value


def sensor_frame(raw: RawFrame, changes: dict[str, Any]) -> SensorFrame:
    """Return the sensor frame of exact readings, with some channels changed."""
    both = {field.name for field in fields(raw)} & {field.name for field in fields(SensorFrame)}
    values = {name: getattr(raw, name) for name in both}
    return SensorFrame(**(values | changes))


def says(port: Input, valid: bool, condition: Callable[[Any], Any] = lambda data: True) -> Any:
    """Return a message that waits on a port, is (in)valid and meets a condition, or None."""
    while (received := port.read()) is not None:
        if received.envelope.valid == valid and condition(received.data):
            return received
    return None
