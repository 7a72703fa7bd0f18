"""One whole robot on the bus for all tests that leave it as they found it."""

from collections.abc import Iterator

import pytest

from robot_model import Robot, load_robot
from tests.system.stack import Stack


@pytest.fixture(scope="session")
def robot() -> Robot:
    return load_robot("icub")


@pytest.fixture(scope="session")
def shared_stack(robot: Robot) -> Iterator[Stack]:
    """Every service, standing on the floor, with ideal sensors."""
    with Stack(robot) as stack:
        stack.await_whole()
        yield stack


@pytest.fixture
def stack(shared_stack: Stack) -> Iterator[Stack]:
    """The shared stack, whole before and after the test."""
    shared_stack.assert_running()
    yield shared_stack
    try:
        shared_stack.assert_running()
    finally:
        shared_stack.mend()
