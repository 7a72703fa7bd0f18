"""Every process ends with status 0 within five seconds of a signal, and leaves no child."""

import signal
import time
from collections.abc import Iterable

import psutil
import pytest

from robot_model import Robot
from tests.system.stack import Stack

pytestmark = [pytest.mark.system, pytest.mark.timeout(300)]
WITHIN = 5.0  # s


def assert_ends(stack: Stack, number: signal.Signals, names: Iterable[str]) -> None:
    """Send a signal to processes and see them end with status 0, silently, without children."""
    children = stack.children()
    for name in names:
        stack.processes[name].send(number)
    deadline = time.monotonic() + WITHIN
    for name in names:
        process = stack.processes[name]
        assert process.ended(max(0.1, deadline - time.monotonic())) == 0, process.output
        assert "Traceback" not in process.output, process.output
    assert not psutil.wait_procs(children, timeout=1.0)[1]


def test_sigint_ends_every_process_cleanly(robot: Robot):
    with Stack(robot) as stack:
        assert_ends(stack, signal.SIGINT, stack.processes)


def test_sigterm_ends_every_process_cleanly_also_while_hub_and_plant_hang(robot: Robot):
    hanging = ["hub", "robot_sim"]
    with Stack(robot) as stack:
        for name in hanging:
            stack.suspend(name)
        assert_ends(stack, signal.SIGTERM, stack.processes.keys() - hanging)
        for name in hanging:
            stack.resume(name)
        assert_ends(stack, signal.SIGTERM, hanging)
