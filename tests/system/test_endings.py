"""Every process ends with status 0 within five seconds of SIGTERM, and leaves no child.

The robot that tests share ends by SIGINT, as strictly.
"""

import signal

import pytest

from robot_model import Robot
from tests.system.stack import Stack

pytestmark = [pytest.mark.system, pytest.mark.timeout(300)]


def test_sigterm_ends_every_process_cleanly_also_while_hub_and_plant_hang(robot: Robot):
    hanging = ["hub", "robot_sim"]
    with Stack(robot) as stack:
        for name in hanging:
            stack.suspend(name)
        stack.assert_ends(signal.SIGTERM, stack.processes.keys() - hanging)
        for name in hanging:
            stack.resume(name)
        stack.assert_ends(signal.SIGTERM, hanging)
