"""All services of a robot as processes, and a look at what they say."""

import signal
import time
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from typing import Any, TypeVar

import psutil

from bus import Input, Node, RpcError
from bus.testing import Process, free_port
from robot_model import Robot, messages, ports

T = TypeVar("T")
MODULES = {
    "robot_sim": "robot_sim",
    "sensor_server": "services.sensor_server",
    "base_estimator": "services.base_estimator",
    "torque_observer": "services.torque_observer",
    "gravity_compensator": "services.gravity_compensator",
    "contact_detector": "services.contact_detector",
    "dashboard": "dashboard",
}
# what is computed, and must therefore be valid or say why not
STREAMS = ("sensors", "base", "torques", "wrenches", "ft_prediction")
STREAMS += ("gravity", "residuals", "contacts")
SETTINGS = {
    # what is tested here does not depend on speed, and a loaded machine must not spoil it
    "robot_sim": ("--set", "speed=0.3"),
    "dashboard": ("--set", "idle_rate=10"),  # Hz at which an unwatched page reads its inputs
}
PATIENCE = 100.0  # s; two loaded cores
SILENT = 0.5  # s without a message
END_WITHIN = 5.0  # s


class Stack:
    """A hub and every service, each a process; use it in a ``with`` statement.

    Args:
        robot: Whose ports are watched.
        settings: Arguments of services besides their defaults.
        without: Services that are not needed.
    """

    def __init__(
        self,
        robot: Robot,
        settings: Mapping[str, Sequence[str]] | None = None,
        without: Collection[str] = (),
    ):
        self.robot = robot
        self.endpoint = f"tcp/127.0.0.1:{free_port()}"
        self.processes: dict[str, Process] = {}
        self._settings = {**SETTINGS, **(settings or {})}
        self._inputs: dict[str, Input] = {}
        self._node: Node | None = None
        self._services = [name for name in MODULES if name not in without]

    @property
    def node(self) -> Node:
        """The observer's place on the bus."""
        assert self._node is not None
        return self._node

    def __enter__(self) -> "Stack":
        try:
            self.start("hub")
            for name in self._services:
                self.start(name)
            self._node = Node("observer", connect=self.endpoint, signals=False)
            for key in STREAMS:
                self._inputs[key] = self.listen(key)
            self.node.ready(PATIENCE)
            self.await_ready(self._services)
            return self
        except BaseException:
            self.__exit__()
            raise

    def __exit__(self, *_: object) -> None:
        if self._node is not None:
            self._node.close()
        for process in reversed(self.processes.values()):
            process.clean_up()

    def listen(self, key: str, depth: int = 1) -> Input:
        """Return an input of the observer's on a port of the robot."""
        return self.node.input(
            f"/observer/{key}:i",
            getattr(messages, ports.port(key).message),
            source=ports.name(key, self.robot),
            depth=depth,
            rate=ports.rate(key),
            model=self.robot.model_hash,
            dimensions=self.robot.dimensions,
        )

    # -- processes

    def start(self, name: str) -> Process:
        """Start a service, in the place of one that was ended."""
        if name in self.processes:
            self.processes[name].clean_up()
        self.processes[name] = self.run(name)
        return self.processes[name]

    def run(self, name: str) -> Process:
        """Run a service beside the stack's own."""
        if name == "hub":
            return Process("bus.hub", "--listen", self.endpoint, "--no-announce")
        arguments = self._settings.get(name, ())
        return Process(MODULES[name], "--connect", self.endpoint, *arguments)

    def await_ready(self, names: Iterable[str]) -> None:
        """Wait until the stack's processes are on the bus under these names."""

        def missing() -> list[str]:
            ready = {owner.pid for owner in self.node.directory.services()}
            lost = [name for name in names if self.processes[name].popen.poll() is not None]
            assert not lost, f"{lost[0]} ended:\n{self.processes[lost[0]].output}"
            return [name for name in names if self.processes[name].pid not in ready]

        self.until(lambda: not missing(), lambda: f"not ready: {missing()}")

    def suspend(self, name: str) -> None:
        """Stop a process, as a debugger would."""
        self.processes[name].send(signal.SIGSTOP)

    def resume(self, name: str) -> None:
        """Let a suspended process go on."""
        self.processes[name].send(signal.SIGCONT)

    def mend(self) -> None:
        """Resume and restart what a test left suspended or ended, and wait for a whole stack."""
        for name, process in self.processes.items():
            if process.popen.poll() is None:
                self.resume(name)
            else:
                self.start(name)
        self.await_ready(self.processes)
        self.await_whole()

    @property
    def pids(self) -> dict[str, int]:
        """Process of each service."""
        return {name: process.pid for name, process in self.processes.items()}

    def assert_running(self, *but: str) -> None:
        """Fail when a process has ended, other than those named."""
        for name, process in self.processes.items():
            status = process.popen.poll()
            assert name in but or status is None, f"{name} ended with {status}:\n{process.output}"

    def assert_ends(self, number: signal.Signals, names: Iterable[str]) -> None:
        """Send a signal to processes and see them end with status 0, silently, without children."""
        children = self.children()
        for name in names:
            self.processes[name].send(number)
        deadline = time.monotonic() + END_WITHIN
        for name in names:
            process = self.processes[name]
            assert process.ended(max(0.1, deadline - time.monotonic())) == 0, process.output
            assert "Traceback" not in process.output, process.output
        assert not psutil.wait_procs(children, timeout=1.0)[1]

    def children(self) -> list[psutil.Process]:
        """Every process that the services have started themselves."""
        return [
            child
            for process in self.processes.values()
            if process.popen.poll() is None
            for child in psutil.Process(process.pid).children(recursive=True)
        ]

    # -- what they say

    def newest(self, key: str) -> Any:
        """Return the newest message of a stream, None before the first."""
        port = self._inputs[key]
        port.newest()
        return port.latest and port.latest.data

    def state(self, key: str) -> str:
        """Return ``valid``, ``silent``, or the reason why a stream is invalid."""
        port = self._inputs[key]
        port.newest()
        if port.latest is None or port.silence > SILENT:
            return "silent"
        envelope = port.latest.envelope
        if not envelope.valid:
            assert envelope.reason, f"{key} is invalid without a reason"
        return "valid" if envelope.valid else envelope.reason

    def states(self) -> dict[str, str]:
        """Return the state of every stream."""
        return {key: self.state(key) for key in STREAMS}

    def await_whole(self) -> None:
        """Wait until all streams are valid."""
        self.until(lambda: set(self.states().values()) == {"valid"}, lambda: str(self.states()))

    def ask(self, service: str, verb: str, **arguments: Any) -> Any:
        """Call a verb of a service."""
        return self.node.call(ports.rpc(service), verb, arguments, timeout=30.0)

    def simulate(self, verb: str, **arguments: Any) -> Any:
        """Call a verb of the plant."""
        return self.node.call(ports.sim_rpc(self.robot), verb, arguments, timeout=30.0)

    def status(self, service: str, timeout: float = 5.0) -> dict[str, Any]:
        """Return a service's status; empty when it does not answer."""
        try:
            return self.node.call(ports.rpc(service), "status", {}, timeout)
        except RpcError:
            return {}

    def until(
        self, predicate: Callable[[], T | None], what: Callable[[], str], timeout: float = PATIENCE
    ) -> T:
        """Return the first true value; fail with ``what()`` and what the processes wrote."""
        deadline = time.monotonic() + timeout
        while not (value := predicate()):
            if time.monotonic() > deadline:
                raise AssertionError(f"not within {timeout:g} s: {what()}\n{self.outputs()}")
            time.sleep(0.01)
        return value

    def outputs(self) -> str:
        """Return the last lines that each process wrote."""
        return "\n".join(
            f"--- {name}:\n{process.output[-1500:]}" for name, process in self.processes.items()
        )
