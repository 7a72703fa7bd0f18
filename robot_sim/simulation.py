"""The running plant: ports, pace, pause and lockstep around ``Plant``."""

import logging
import time
from collections.abc import Callable
from functools import partial

from bus import LockstepTimeout, Node, Pending
from bus.clock import ClockServer, State
from bus.envelope import SIMULATED
from bus.lockstep import Lockstep
from robot_model import Robot, ports
from robot_model.messages import GroundTruth, MotorCommand, RawFrame
from robot_sim.config import SimConfig
from robot_sim.pace import RealTime, SlipWatch
from robot_sim.plant import TICK, Base, Plant
from robot_sim.scenario import ScenarioPlayer, load_scenario

logger = logging.getLogger(__name__)

PATIENCE = 5.0  # s of wall time until a missing lockstep participant is an error
IDLE = 0.05  # s
SLOW = 0.1  # of simulated to wall time, while others need the processors


class Simulation:
    """Moves a plant through time and its samples to the bus."""

    def __init__(self, node: Node, robot: Robot, config: SimConfig):
        self._node, self._config = node, config
        self.plant = Plant(robot, config.base, config.profile, config.seed, config.plant)
        self.play(config.scenario)
        self.paused = config.paused
        self.ticks = self.refused = 0
        self.waiting_for = ""
        self._speed, self._slow, self._slow_until = config.speed, config.speed, 0
        self._pace = RealTime(round(TICK / config.speed), config.burst)
        self._slip_watch = SlipWatch()
        self._steps: list[tuple[int, Pending]] = []  # ticks asked for while paused
        self._resets = 0
        self._open_ports(robot)

    def play(self, scenario: str) -> None:
        """Begin a scenario, by name or file, now; LookupError or ValueError when it is wrong."""
        plant = self.plant
        self.player = ScenarioPlayer(plant, load_scenario(scenario, plant.robot), self._config.seed)
        self.scenario = scenario

    def _open_ports(self, robot: Robot) -> None:
        node, config = self._node, self._config
        sizes = {"model": robot.model_hash, "dimensions": robot.dimensions}
        self._raw = node.output(ports.name("raw", robot), RawFrame, ports.rate("raw"), **sizes)
        truth, rate = ports.name("truth", robot), ports.rate("truth")
        self._truth = node.output(truth, GroundTruth, rate, **sizes) if config.truth else None
        self._truth_period = round(1e9 / rate)
        self._clock = ClockServer(node, ports.name("clock", robot), ports.rate("clock"))
        self._commands = node.input(
            ports.name("robot_sim_motor_command", robot),
            MotorCommand,
            source=config.inputs.get("motor_command", ports.name("motor_command", robot)),
            polled=True,  # read at every tick
            **sizes,
        )
        self._lockstep = None
        if config.lockstep:
            if not config.participants:
                raise ValueError("lockstep: participants: expected at least one service, got none")
            self._lockstep = Lockstep(node, config.participants)

    @property
    def state(self) -> State:
        return "paused" if self.paused else "running"

    @property
    def slipped(self) -> int:
        """Ticks that real time gave up because the machine stalled."""
        return self._pace.slipped

    def run(self) -> None:
        """Run until the node is asked to end."""
        self._tell_time()
        if self._lockstep is not None:  # who comes later would miss the first tick, and we wait
            self._await_participants(self._lockstep.join)
        self._pace.start(time.monotonic_ns())
        self.slow_down(SLOW, self._config.slow_start)
        while self._node.running:
            if self.paused:
                self._run_paused()
            elif self._config.pace == "real_time":
                self._run_real_time()
            else:
                self._run_fast()

    def _run_real_time(self) -> None:
        now = time.monotonic_ns()
        speed = self._slow if now < self._slow_until else self._speed
        self._pace.change(round(TICK / speed), now)
        for _ in range(self._pace.due(now)):
            self._tick()
        if lost := self._slip_watch.lost(time.monotonic_ns(), self.ticks, self.slipped):
            logger.warning(
                "this machine is too slow: %.0f %% of real time is lost; speed %.2g would hold",
                *(100.0 * lost, 0.8 * (1.0 - lost) * self._speed),
            )
        # Sleeping, and only then looking at the bus: waiting on the bus would wake at
        # every command that arrives between two ticks.
        time.sleep(self._pace.remaining(time.monotonic_ns()))
        self._node.wait(0.0)

    def _run_fast(self) -> None:
        for _ in range(self._config.burst):
            self._tick()
        self._node.wait(0.0)

    def _run_paused(self) -> None:
        if not self._steps:
            self._node.wait(IDLE)
            return
        ticks, pending = self._steps.pop(0)
        for _ in range(min(ticks, self._config.burst)):
            self._tick()
        if ticks > self._config.burst:
            self._steps.insert(0, (ticks - self._config.burst, pending))
        else:
            pending.reply({"time": self.plant.time})
        self._node.wait(0.0)

    def _tick(self) -> None:
        plant = self.plant
        self._take_command()
        self.player.step()
        plant.step()
        acquired = time.time_ns()  # the instant exists now, and its sensors are read
        self.ticks += 1
        stamp = plant.time
        self._raw.write(plant.raw(), stamp=stamp, clock=SIMULATED, acquired=acquired)
        truth = self._truth
        if truth is not None and stamp % self._truth_period == 0 and truth.wanted(stamp):
            truth.write(plant.truth(), stamp=stamp, clock=SIMULATED, acquired=acquired)
        self._tell_time()
        if self._lockstep is not None:
            self._await_participants(partial(self._lockstep.wait, self.plant.time))

    def _take_command(self) -> None:
        received = self._commands.newest()
        if received is None or not received.envelope.valid:
            return
        command = received.data
        try:
            self.plant.boards.command(command.mode, command.value, command.feedforward)
        except ValueError as error:
            self.refused += 1
            logger.warning("refused a motor command: %s", error)

    def _await_participants(self, wait: Callable[[float], None]) -> None:
        """Wait for all participants; a missing one is named every five seconds."""
        resets = self._resets
        while self._node.running and self._resets == resets:
            try:
                wait(PATIENCE)
                break
            except LockstepTimeout as error:
                self.waiting_for = str(error)
                logger.error("lockstep: %s; still waiting", error)
                self._tell_time()
        self.waiting_for = ""

    def _tell_time(self) -> None:
        self._clock.update(self.plant.time, self.state)

    # -- what the verbs do

    def pause(self) -> None:
        """Stop simulated time."""
        self.paused = True
        self._tell_time()

    def resume(self) -> None:
        """Let simulated time run; no tick is made up for the pause."""
        self._drop_steps("resumed")
        self.paused = False
        self._pace.start(time.monotonic_ns())
        self._tell_time()

    def set_speed(self, speed: float) -> None:
        """Change the speed of simulated to wall time."""
        self._speed = speed

    def slow_down(self, speed: float, seconds: float) -> None:
        """Go at most at a speed for some seconds of wall time, and then as before."""
        self._slow = min(speed, self._speed)
        self._slow_until = time.monotonic_ns() + round(seconds * 1e9)

    def step(self, ticks: int) -> Pending:
        """Take ticks while paused; the answer comes when they are done."""
        pending = Pending()
        self._steps.append((ticks, pending))
        return pending

    def reset(self) -> None:
        """Go back to the start; a pause stays."""
        self._restart(self.plant.base_mode)

    def change_base(self, base: Base) -> None:
        """Put the robot on the pole or on the floor, at the start."""
        self._restart(base)

    def _restart(self, base: Base) -> None:
        self._drop_steps("reset")
        self._resets += 1
        self.plant.base(base)
        self.player.restart()
        self._tell_time()

    def _drop_steps(self, why: str) -> None:
        for _, pending in self._steps:
            pending.fail(f"the plant was {why} before the steps were done")
        self._steps = []
