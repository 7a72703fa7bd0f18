"""Hardware for the sensor server's tests: in memory, and the plant's side of the bus."""

import time
from collections import deque
from collections.abc import Iterator
from pathlib import Path
from queue import Queue
from typing import Any

import numpy as np
import pytest

from bus import Node
from bus.encoder import Encoder
from bus.parameters import Parameters
from bus.recording.reader import Message, Port
from bus.schema import fields_of, type_name
from bus.testing import eventually, running_hub
from robot_model import Robot, load_robot, ports
from robot_model.messages import MotorCommand, RawFrame
from services.sensor_server.config import SensorServerConfig
from services.sensor_server.driver import Driver, FtConvention, Reading
from services.sensor_server.plant_driver import PlantDriver
from services.sensor_server.replay_driver import ReplayDriver
from services.sensor_server.service import SensorServer

TICK = 1_000_000  # [ns]


def raw_frame(robot: Robot, changes: dict[str, Any]) -> RawFrame:
    """Return a complete frame of a robot at home, with velocities and accelerations."""
    n, k, m = (robot.dimensions[letter] for letter in "nkm")
    values = {
        "q": np.array(robot.home),
        "dq": np.zeros(n),
        "ddq": np.zeros(n),
        "motor_torque": np.zeros(n),
        "ft": np.ones((k, 6)),
        "imu_gyro": np.zeros((m, 3)),
        "imu_acc": np.tile([0.0, 0.0, 9.81], (m, 1)),
        "imu_dgyro": np.zeros((m, 3)),
        "joint_valid": np.ones(n, dtype=bool),
        "ft_valid": np.ones(k, dtype=bool),
        "imu_valid": np.ones(m, dtype=bool),
    }
    return RawFrame(**(values | changes))


class MemoryDriver:
    """Readings that a test puts in, commands that it takes out."""

    ft_convention: FtConvention = "wrenchbus"
    checked = False

    def __init__(self, node: Node, robot: Robot, config: SensorServerConfig):
        self._node = node
        self._robot = robot
        self._readings: deque[Reading] = deque()
        self._arrival = 0.0
        self.commands: list[MotorCommand] = []
        self.paused = False
        self.opened = False

    def open(self) -> None:
        self.opened = True

    def deliver(self, stamp: int, **changes: Any) -> None:
        frame = raw_frame(self._robot, changes)
        self._readings.append(Reading(frame, stamp, 1, time.time_ns()))

    def read(self, timeout: float) -> Reading | None:
        if not self._readings:
            self._node.wait(timeout)
            return None
        self._arrival = time.monotonic()
        return self._readings.popleft()

    @property
    def silence(self) -> str:
        silent = time.monotonic() - self._arrival
        return f"the memory is silent for {silent * 1e3:.0f} ms" if silent > 0.02 else ""

    def write(self, command: MotorCommand, reading: Reading) -> None:
        self.commands.append(command)

    def close(self) -> None:
        self.opened = False


class MemoryHardware:
    """The contract's view of the driver in memory."""

    def __init__(self, node: Node, robot: Robot, config: SensorServerConfig):
        self._memory = MemoryDriver(node, robot, config)
        self.driver: Driver = self._memory

    def connect(self) -> None:
        """Open the driver and everything behind it."""
        self.driver.open()

    def deliver(self, stamp: int, **changes: Any) -> None:
        """Let the hardware measure a frame."""
        self._memory.deliver(stamp, **changes)

    def commands(self) -> list[MotorCommand]:
        """Return the commands that the boards have got so far."""
        return self._memory.commands

    def close(self) -> None:
        """Nothing is behind the driver."""


class PlantHardware:
    """The plant's side of the bus, as a second node."""

    def __init__(self, node: Node, robot: Robot, config: SensorServerConfig):
        self.driver: Driver = PlantDriver(node, robot, config)
        self._node, self._robot = node, robot
        self._plant = Node("robot_sim", connect=node.endpoint, signals=False)
        self._commands: list[MotorCommand] = []

    def connect(self) -> None:
        types = {"model": self._robot.model_hash, "dimensions": self._robot.dimensions}
        self.driver.open()
        self._node.ready()
        self._raw = self._plant.output(ports.name("raw", self._robot), RawFrame, **types)
        self._boards = self._plant.input(
            ports.name("robot_sim_motor_command", self._robot),
            MotorCommand,
            source=ports.name("motor_command", self._robot),
            depth=64,
            **types,
        )
        self._plant.ready()
        eventually(lambda: self._raw.matched, what="the driver listens to the plant")
        eventually(lambda: self._node.directory.leader(self._raw.name), what="the plant is known")

    def deliver(self, stamp: int, **changes: Any) -> None:
        self._raw.write(raw_frame(self._robot, changes), stamp=stamp, clock=1)

    def commands(self) -> list[MotorCommand]:
        while (received := self._boards.read()) is not None:
            self._commands.append(received.data)
        return self._commands

    def close(self) -> None:
        self._plant.close()


class GrowingTape:
    """A recording to which a test adds frames while it is played; its time is wall time."""

    def __init__(self, robot: Robot):
        self.path, self.start = Path("growing.mcap"), time.time_ns()
        self.end = self.start + 3_600_000_000_000
        name, fields = ports.name("raw", robot), [f.describe() for f in fields_of(RawFrame)]
        self.ports = {name: Port(name, type_name(RawFrame), "output", 1000.0, fields, 0)}
        self._name, self._messages = name, Queue[bytes | None]()
        sizes = {"model": robot.model_hash, "dimensions": robot.dimensions}
        self._encoder, self._seq = Encoder(RawFrame, bytes(16), **sizes), 0

    def add(self, frame: RawFrame, stamp: int) -> None:
        """Record a frame, now."""
        self._seq += 1
        now = time.time_ns()
        self._messages.put(self._encoder.encode(frame, self._seq, stamp, 1, now, now))

    def messages(self, *_: Any) -> Iterator[Message]:
        while (data := self._messages.get()) is not None:
            yield Message(self._name, data, time.time_ns())

    def close(self) -> None:
        """There is no more."""
        self._messages.put(None)


class ReplayHardware:
    """A recording in the place of hardware."""

    def __init__(self, node: Node, robot: Robot, config: SensorServerConfig):
        self._replay = ReplayDriver(node, robot, config)
        self.driver: Driver = self._replay
        self._node, self._robot = node, robot

    def connect(self) -> None:
        self._tape = GrowingTape(self._robot)
        self._replay.load(self._tape)  # type: ignore[arg-type]  # as much of one as is needed
        self._node.ready()

    def deliver(self, stamp: int, **changes: Any) -> None:
        self._tape.add(raw_frame(self._robot, changes), stamp)

    def commands(self) -> None:
        """A recording has no boards."""

    @property
    def ignored(self) -> int:
        """Commands that went nowhere."""
        return self._replay.ignored

    def close(self) -> None:
        self.driver.close()
        self._tape.close()


HARDWARE = {"memory": MemoryHardware, "plant": PlantHardware, "replay": ReplayHardware}
Hardware = MemoryHardware | PlantHardware | ReplayHardware


@pytest.fixture(scope="session")
def hub() -> Iterator[str]:
    """One hub for all tests of this folder: a new one for each would cost most of their time."""
    with running_hub() as endpoint:
        yield endpoint


@pytest.fixture
def node(hub: str) -> Iterator[Node]:
    """The server's place on the bus."""
    settings = Parameters(SensorServerConfig())
    with Node("sensor_server", connect=hub, signals=False, parameters=settings) as opened:
        yield opened


@pytest.fixture(scope="session")
def robot() -> Robot:
    return load_robot("icub")


@pytest.fixture(params=list(HARDWARE))
def hardware(request, node: Node, robot: Robot) -> Iterator[Hardware]:
    """A driver and the hardware behind it, connected."""
    hardware = HARDWARE[request.param](node, robot, SensorServerConfig())
    try:
        hardware.connect()
        yield hardware
    finally:
        hardware.close()


class Bench:
    """A sensor server on a driver in memory, stepped by the test."""

    def __init__(self, node: Node, robot: Robot, convention: FtConvention = "wrenchbus"):
        config = SensorServerConfig()
        self.robot, self.node = robot, node
        self.driver = MemoryDriver(node, robot, config)
        self.driver.ft_convention = convention
        self.server = SensorServer(node, robot, config, self.driver)
        self.stamp = 0

    def step(self, **changes: Any) -> None:
        """Let the hardware measure the next frame, and the server handle it."""
        self.stamp += TICK
        self.driver.deliver(self.stamp, **changes)
        self.server.spin()

    def run(self, frames: int, **changes: Any) -> None:
        """Step several times."""
        for _ in range(frames):
            self.step(**changes)


@pytest.fixture
def bench(node: Node, robot: Robot) -> Bench:
    return Bench(node, robot)


@pytest.fixture
def urdf_bench(node: Node, robot: Robot) -> Bench:
    """A server whose driver delivers raw readings, as the URDF describes its sensors."""
    return Bench(node, robot, "urdf")


@pytest.fixture
def client(hub: str) -> Iterator[Node]:
    """A second place on the bus."""
    with Node("client", connect=hub, signals=False) as opened:
        yield opened
