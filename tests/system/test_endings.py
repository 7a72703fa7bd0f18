"""Every process ends with status 0 within five seconds of a signal, and leaves no child."""

import signal
import time

import psutil
import pytest

from robot_model import Robot
from tests.system.stack import Stack

pytestmark = [pytest.mark.system, pytest.mark.timeout(300)]
WITHIN = 5.0  # s


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT], ids=lambda n: n.name)
def test_a_signal_ends_every_process_cleanly(robot: Robot, number: signal.Signals):
    with Stack(robot) as stack:
        stack.await_whole()
        children = stack.children()
        for process in stack.processes.values():
            process.send(number)
        deadline = time.monotonic() + WITHIN
        for name, process in stack.processes.items():
            status = process.popen.wait(max(0.1, deadline - time.monotonic()))
            assert status == 0, f"{name} ended with {status}:\n{process.output}"
            assert "Traceback" not in process.output, process.output
        assert not psutil.wait_procs(children, timeout=1.0)[1]


def test_a_service_ends_also_when_hub_and_plant_hang(robot: Robot):
    with Stack(robot) as stack:
        stack.suspend("hub")
        stack.suspend("robot_sim")
        for name in set(stack.processes) - {"hub", "robot_sim"}:
            assert stack.processes[name].stop() == 0
