"""One whole robot on the bus for all tests that leave it as they found it."""

import signal
from collections.abc import Iterator

import pytest

from robot_model import Robot
from tests.system.stack import Stack

# tared soon, though the robot still settles: nothing here depends on what is felt
DETECTOR = ("--set", "tare={window: 0.2, patience: 0.0}")


@pytest.fixture(scope="package")
def shared_stack(robot: Robot) -> Iterator[Stack]:
    """Every service, standing on the floor, with ideal sensors; ended as Ctrl-C does."""
    with Stack(robot, {"contact_detector": DETECTOR}) as stack:
        stack.await_whole()
        yield stack
        stack.assert_ends(signal.SIGINT, stack.processes)


@pytest.fixture
def stack(shared_stack: Stack) -> Iterator[Stack]:
    """The shared stack, whole before and after the test."""
    shared_stack.assert_running()
    yield shared_stack
    try:
        shared_stack.assert_running()
    finally:
        shared_stack.mend()
