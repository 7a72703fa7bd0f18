"""A pytest plugin for processes on the bus: ``pytest_plugins = ["bus.testing"]``.

Fixtures ``hub`` (its endpoint), ``start`` (a module as a process, ready on the bus)
and ``node`` (a place on the bus for the test); functions `free_port`, `eventually`,
`collect`.
Nothing is left running: what still runs after a test is killed with its children.
"""

import os
import signal
import socket
import subprocess
import tempfile
import time
from collections.abc import Callable, Generator, Iterator
from contextlib import contextmanager, suppress
from typing import Any, TypeVar

import pytest

from bus.child import command
from bus.envelope import Received
from bus.input import Input
from bus.introspection import wait_for_port, wait_for_service
from bus.node import Node

T = TypeVar("T")
STOP_WITHIN = 15.0  # s, on a loaded machine; usually 0.2
READY_WITHIN = 60.0  # s, on a loaded machine
_FAILED = pytest.StashKey[bool]()
_ONE_THREAD = {"OMP_NUM_THREADS": "1", "OPENBLAS_NUM_THREADS": "1"}


def free_port() -> int:
    """Return a loopback TCP port that is free at present."""
    with socket.socket() as sock:
        sock.bind(("127.0.0.1", 0))
        return sock.getsockname()[1]


def eventually(predicate: Callable[[], T], timeout: float = 60.0, what: str = "") -> T:
    """Return the first true value of ``predicate()``; fail when none came in time."""
    deadline = time.monotonic() + timeout
    while not (value := predicate()):
        if time.monotonic() > deadline:
            raise AssertionError(
                f"not within {timeout:g} s: {what or repr(predicate)} (last: {value!r})"
            )
        time.sleep(0.002)
    return value


def collect(node: Node, port: Input, count: int, timeout: float = 60.0) -> list[Received]:
    """Return the next ``count`` messages of an input of the test's node, in order."""
    messages: list[Received] = []

    def enough() -> bool:
        node.wait(0.01)
        while len(messages) < count and (received := port.read()) is not None:
            messages.append(received)
        return len(messages) >= count

    eventually(enough, timeout, f"{count} messages on {port.name}")
    return messages


class Process:
    """A Python module running as a process group of its own."""

    def __init__(self, module: str, *arguments: str, environment: dict[str, str] | None = None):
        self.name = module
        self._log = tempfile.TemporaryFile()
        self.popen = subprocess.Popen(
            command(module, *arguments),
            stdout=self._log,
            stderr=self._log,
            stdin=subprocess.DEVNULL,
            start_new_session=True,
            env={**os.environ, **_ONE_THREAD, **(environment or {})},
        )
        self.pid = self.popen.pid
        self.expected: int | None = 0  # exit status asserted at the end; None when killed

    @property
    def output(self) -> str:
        """All that the process has written so far."""
        self._log.seek(0)
        return self._log.read().decode(errors="replace")

    def send(self, number: int) -> None:
        """Send a signal to the process."""
        self.popen.send_signal(number)

    def kill(self) -> None:
        """Kill the process, as a crash would."""
        self.expected = None
        self.popen.kill()
        self.popen.wait()

    def stop(self, number: int = signal.SIGTERM, timeout: float = STOP_WITHIN) -> int:
        """End the process by a signal; return its exit status, fail when it does not end."""
        if self.popen.poll() is None:
            self.popen.send_signal(number)
        return self.ended(timeout)

    def ended(self, timeout: float = STOP_WITHIN) -> int:
        """Return the exit status; fail, showing its threads, when it does not end in time."""
        try:
            return self.popen.wait(timeout)
        except subprocess.TimeoutExpired:
            self._show_stacks()
            raise AssertionError(
                f"{self.name} did not end within {timeout} s\n{self.output}"
            ) from None

    def _show_stacks(self) -> None:
        """Let the process write where its threads are."""
        self.send(signal.SIGUSR1)
        with suppress(subprocess.TimeoutExpired):
            self.popen.wait(1.0)

    def clean_up(self) -> None:
        """Kill whatever is left of the process group."""
        if self.popen.poll() is None or not _exists(self.pid):
            try:
                os.killpg(self.pid, signal.SIGKILL)
            except ProcessLookupError:
                pass
        self.popen.wait()
        self._log.close()


def _exists(pid: int) -> bool:
    """Whether a process has this number; after ours was reaped, it is a stranger with a group."""
    try:
        os.kill(pid, 0)
    except (ProcessLookupError, PermissionError) as error:
        return isinstance(error, PermissionError)
    return True


def _finish(processes: list[Process]) -> None:
    """Stop all, newest first; then complain about those that did not end as expected."""
    complaints = []
    for process in reversed(processes):
        try:
            process.send(signal.SIGCONT)
            status = process.stop()
            if process.expected is not None and status != process.expected:
                complaints.append(f"{process.name} ended with {status}:\n{process.output}")
        except AssertionError as error:
            complaints.append(str(error))
        finally:
            process.clean_up()
    if complaints:
        pytest.fail("\n".join(complaints), pytrace=False)


@contextmanager
def running_hub() -> Iterator[str]:
    """Run a hub on a free loopback port; return its endpoint. For fixtures of a wider scope."""
    endpoint, process = start_hub()
    try:
        yield endpoint
    finally:
        _finish([process])


def start_hub(endpoint: str | None = None) -> tuple[str, Process]:
    """Start a hub that is not announced to others; return its endpoint and its process."""
    endpoint = endpoint or f"tcp/127.0.0.1:{free_port()}"
    process = Process("bus.hub", "--listen", endpoint, "--settle", "0", "--no-announce")
    try:
        _await_ready(endpoint, process, READY_WITHIN)
    except BaseException:
        process.clean_up()
        raise
    return endpoint, process


@pytest.fixture(scope="session")
def _hubs() -> Iterator[list[tuple[str, Process]]]:
    hubs: list[tuple[str, Process]] = []
    yield hubs
    _finish([process for _, process in hubs])


@pytest.fixture
def hub(_hubs: list[tuple[str, Process]]) -> str:
    """Return the endpoint of a hub on a free loopback port; tests share it while it lives."""
    if not _hubs or _hubs[-1][1].popen.poll() is not None:
        _hubs.append(start_hub())
    return _hubs[-1][0]


@pytest.fixture
def node(hub: str) -> Iterator[Node]:
    """Return a node for the test, connected to the hub and not yet ready."""
    with Node("test", connect=hub, signals=False) as opened:
        yield opened


@pytest.fixture
def start(hub: str, request: pytest.FixtureRequest) -> Iterator[Callable[..., Process]]:
    """Return ``start(module, *arguments, timeout=60.0, environment=None)``.

    It runs ``python -m module --connect HUB arguments`` and returns when the process's
    readiness token is on the bus (a ``service`` given besides must be its name). At the
    end of the test every process must end with 0 within 5 s of SIGTERM. When the test
    fails, what the processes wrote is shown.
    """
    processes: list[Process] = []

    def run(
        module: str,
        *arguments: str,
        service: str | None = None,
        timeout: float = READY_WITHIN,
        environment: dict[str, str] | None = None,
    ) -> Process:
        process = Process(module, "--connect", hub, *arguments, environment=environment)
        processes.append(process)
        name = _await_ready(hub, process, timeout)
        assert service in (None, name), f"{module} calls itself {name}, expected {service}"
        return process

    run.processes = processes  # type: ignore[attr-defined]  # for tests of failing processes
    try:
        yield run
    finally:
        if request.node.stash.get(_FAILED, False):
            for process in processes:
                print(f"--- {process.name} (pid {process.pid}) wrote:\n{process.output}")
        _finish(processes)


@pytest.hookimpl(wrapper=True)
def pytest_runtest_makereport(item: pytest.Item) -> Generator[None, Any, Any]:
    """Let the fixtures know that the test failed."""
    report = yield
    if report.failed:
        item.stash[_FAILED] = True
    return report


def _await_ready(endpoint: str, process: Process, timeout: float) -> str:
    """Return the service's name when its token comes; fail at once when the process ends."""
    deadline = time.monotonic() + timeout
    with Node("start", connect=endpoint, signals=False) as watcher:
        while True:
            for owner in watcher.directory.services():
                if owner.pid == process.pid:
                    return owner.service
            status = process.popen.poll()
            late = time.monotonic() > deadline
            if late or status is not None:
                trouble = f"ended with {status}" if not late else f"is not ready in {timeout:g} s"
                raise AssertionError(f"{process.name} {trouble}:\n{process.output}")
            time.sleep(0.005)


__all__ = [
    "Process",
    "collect",
    "eventually",
    "free_port",
    "running_hub",
    "start_hub",
    "wait_for_port",
    "wait_for_service",
]
