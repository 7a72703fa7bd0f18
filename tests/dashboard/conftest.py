"""What the tests of the page share."""

import pytest

from dashboard.placement import Placement
from robot_model import Robot, load_robot

pytest_plugins = ["bus.testing"]


@pytest.fixture(scope="session")
def robot() -> Robot:
    return load_robot("icub")


@pytest.fixture
def placement(robot: Robot) -> Placement:
    """The robot at home, its base turned by a quarter about the vertical, 0.6 m up."""
    placed = Placement(robot)
    half = 0.5**0.5
    placed.update(robot.home, [0.0, 0.0, 0.6], [half, 0.0, 0.0, half])
    return placed
