"""The sensor server: one frame for the whole robot, and every command to its boards."""

import time
from contextlib import closing

from bus import Node
from robot_model import Robot, load_robot
from services.sensor_server.command_ports import CommandPorts
from services.sensor_server.config import SensorServerConfig
from services.sensor_server.driver import Driver, make_driver
from services.sensor_server.frames import Frames
from services.sensor_server.measures import RunningTime

WAIT = 0.005  # s; watchdogs and silence are looked at this often when nothing arrives


def main(node: Node, config: SensorServerConfig) -> None:
    """Serve one robot until asked to stop."""
    robot = load_robot(config.robot)
    driver = make_driver(config.driver, node, robot, config)
    with closing(driver):
        driver.open()
        server = SensorServer(node, robot, config, driver)
        node.ready()
        while node.running:
            server.spin()


class SensorServer:
    """Moves readings from the driver to the ports, and commands from the ports to the driver."""

    def __init__(self, node: Node, robot: Robot, config: SensorServerConfig, driver: Driver):
        self._node, self._config, self._driver = node, config, driver
        self._frames = Frames(node, robot, config, driver.ft_convention)
        self._commands = CommandPorts(node, robot, config, driver)
        self._running = RunningTime()
        node.verb("status", self._status, help="state of command, watchdogs, virtual torques")
        node.parameters.on_change(self._configure)

    def spin(self) -> None:
        """Wait for one frame at most, then see to commands and watchdogs."""
        reading = self._driver.read(WAIT)
        self._node.wait(0.0)  # a stop is heard also when frames never let up
        if reading and reading.valid:
            if self._frames.publish(reading):
                self._commands.restart()
        else:
            self._frames.complain(reading.reason if reading else self._driver.silence)
        now = self._now()
        self._commands.listen(now)
        self._commands.act(now, self._frames.frame, self._frames.reading)
        if reading and self._config.lockstep:
            self._node.lockstep.acknowledge(reading.stamp)

    def _now(self) -> float:
        """Seconds of the robot's time: none pass while it is paused."""
        if self._config.lockstep:
            last = self._frames.reading
            return self._running.advance(last.stamp if last else 0)
        return self._running.advance(time.monotonic_ns(), not self._driver.paused)

    def _configure(self, old: SensorServerConfig, new: SensorServerConfig) -> None:
        self._commands.configure(new)
        if new.filter != old.filter:
            self._frames.configure(new)

    def _status(self) -> dict[str, object]:
        return {**self._node.status(), **self._commands.status()}
