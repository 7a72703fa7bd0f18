"""The ports and verbs by which others move the robot."""

import logging
import time
from math import inf

from bus import Envelope, Input, Node
from robot_model import Robot, ports
from robot_model.messages import GravityTorques, JointCommand, JointTorques, SensorFrame
from services.sensor_server.commander import Commander, CommandRefused
from services.sensor_server.config import SensorServerConfig
from services.sensor_server.driver import Driver, Reading
from services.sensor_server.measures import Ages

AGE_WINDOW = 60_000  # virtual torques, a minute at 1 kHz

logger = logging.getLogger(__name__)


class CommandPorts:
    """Reads commands, feed-forward and virtual torques, and tells the driver what to do.

    Virtual torques are not fed back yet: boards in position mode need none. Their
    ages are measured here, where a torque loop would close.
    """

    def __init__(self, node: Node, robot: Robot, config: SensorServerConfig, driver: Driver):
        self._node, self._robot, self._driver = node, robot, driver
        self._commander = Commander(robot, config.command)
        self._ages = Ages(AGE_WINDOW)
        self._torque_joints = 0  # with a valid virtual torque in the last message
        self._acted = -inf  # s
        self._refused, self._refusal, self._logged = 0, "", 0.0
        self._torques = self._input("virtual_torque", JointTorques, config, "torques", depth=64)
        self._gravity = self._input("feedforward", GravityTorques, config, "gravity", depth=1)
        self._commands = self._input("command", JointCommand, config, None, depth=8)
        node.verb("stop", self._stop, help="hold the present posture and refuse commands")
        node.verb("release", self._release, help="accept commands again")
        self.configure(config)

    def configure(self, config: SensorServerConfig) -> None:
        """Take new time limits."""
        self._config = config
        self._commander.configure(config.command)

    def restart(self) -> None:
        """The robot was put back to its start: hold the posture in which it is found."""
        self._commander.restart()

    def _input(
        self, key: str, message: type, config: SensorServerConfig, source: str | None, depth: int
    ) -> Input:
        default = ports.name(source, self._robot) if source else ()
        return self._node.input(
            ports.name(key, self._robot),
            message,
            source=config.inputs.get(key, default),
            depth=depth,
            rate=ports.rate(key),
            model=self._robot.model_hash,
            dimensions=self._robot.dimensions,
            wakes=False,  # read at every frame, or at the watchdogs' rate
        )

    def listen(self, now: float) -> None:
        """Read commands and feed-forward; ``now`` is the robot's running time [s]."""
        received = self._gravity.newest()
        timeout = self._config.command.feedforward_timeout
        if received and received.envelope.valid and not self._late(received.envelope, timeout):
            self._commander.feedforward(received.data.torque, now)
        while (received := self._commands.read()) is not None:
            self._take(received.data, received.envelope, now)

    def _take(self, command: JointCommand, envelope: Envelope, now: float) -> None:
        try:
            timeout = self._config.command.command_timeout
            if command.mode != "position" and self._late(envelope, timeout):
                raise CommandRefused(f"the {command.mode} command is older than {timeout} s")
            self._commander.command(command.mode, command.value, envelope.source, now)
        except CommandRefused as error:
            self._refuse(str(error))

    def _late(self, envelope: Envelope, timeout: float) -> bool:
        """Whether a message lay in some queue too long; in simulated steps nothing is late."""
        return not self._config.lockstep and time.time_ns() - envelope.sent > timeout * 1e9

    def _refuse(self, why: str) -> None:
        self._refused += 1
        self._refusal = why
        if (now := time.monotonic()) - self._logged >= 1.0:
            self._logged = now
            logger.warning("command refused: %s", why)

    def due(self, now: float) -> bool:
        """Whether it is time to look at the watchdogs, or something has changed."""
        return self._commander.changed or now - self._acted >= 1.0 / self._config.command.rate

    def act(self, now: float, frame: SensorFrame, reading: Reading | None) -> None:
        """Let the watchdogs see the time, and tell the boards what to do."""
        self._acted = now
        self._measure_ages()
        self._commander.advance(now)
        if reading is not None:
            self._commander.measured(frame.q, frame.joint_valid)
        if reading is not None and self._commander.ready:
            self._driver.write(self._commander.motor_command(), reading)

    def _measure_ages(self) -> None:
        """Take the ages that the virtual torques had when they arrived."""
        monotonic_to_wall = time.time_ns() - time.monotonic_ns()
        while (received := self._torques.read()) is not None:
            envelope = received.envelope
            self._torque_joints = int(received.data.valid.sum()) if envelope.valid else 0
            if envelope.valid:
                age = received.arrival + monotonic_to_wall - envelope.acquired
                self._ages.add(age * 1e-9)

    def status(self) -> dict[str, object]:
        """Return the state of command, watchdogs and virtual torques."""
        return {
            **self._commander.status(),
            "commands_refused": self._refused,
            "last_refusal": self._refusal,
            "virtual_torque_joints": self._torque_joints,
            "virtual_torque_age": self._ages.summary(),  # s
        }

    def _stop(self) -> dict[str, object]:
        self._commander.stop("stop was asked for")
        return self._commander.status()

    def _release(self) -> dict[str, object]:
        self._commander.release()
        return self._commander.status()
