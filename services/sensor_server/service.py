"""The sensor server: one frame for the whole robot, and every command to its boards."""

import time
from contextlib import closing

from bus import Node
from bus.envelope import SIMULATED
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
        self.frames = Frames(node, robot, config, driver)
        self.commands = CommandPorts(node, robot, config, driver)
        self._wall, self._stamps = RunningTime(), RunningTime()
        self._valid = False  # the last reading
        node.verb("status", self.status, help="state of command, watchdogs, virtual torques")
        node.parameters.on_change(self._configure)

    def spin(self) -> None:
        """Wait for one frame at most, then see to commands and watchdogs."""
        reading = self._driver.read(WAIT)
        self._valid = reading.valid if reading else self._valid
        if reading and reading.valid:
            if self.frames.publish(reading):
                self.commands.restart()
        else:
            self.frames.complain(reading.reason if reading else self._driver.silence)
        now = self._now()
        self.commands.listen(now)
        if self.commands.due(now):
            self._node.wait(0.0)  # a stop is heard also when frames never let up
            self.commands.act(now, self.frames.frame, self.frames.reading)
        if reading and self._config.lockstep:
            self._node.lockstep.acknowledge(reading.stamp)

    def _now(self) -> float:
        """Seconds of the robot's time: none pass while it is paused, few in slow motion.

        Wall time counts where stamps cannot: while frames stay away or are invalid.
        """
        last, paused = self.frames.reading, self._driver.paused
        if last is None or last.clock != SIMULATED:
            return self._wall.advance(time.monotonic_ns(), not paused)
        silent = not (paused or self._config.lockstep) and self._is_silent()
        return self._wall.advance(time.monotonic_ns(), silent) + self._stamps.advance(last.stamp)

    def _is_silent(self) -> bool:
        return not self._valid or bool(self._driver.silence)

    def _configure(self, old: SensorServerConfig, new: SensorServerConfig) -> None:
        old.check_change(new)
        if (new.filter, new.ft) != (old.filter, old.ft):
            self.frames.configure(new)
        self.commands.configure(new)

    def status(self) -> dict[str, object]:
        """Return the state of service, command, watchdogs and calibration."""
        lacking = self.frames.calibrated.lacking
        return {
            **self._node.status(),
            **self.commands.status(),
            "ft_without_temperature": lacking,  # invalid therefore
        }
