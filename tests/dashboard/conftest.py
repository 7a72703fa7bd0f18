"""What the tests of the page share."""

from collections.abc import Iterator

import numpy as np
import pytest

from dashboard.config import DashboardConfig
from dashboard.placement import Placement
from dashboard.server import PageServer, open_server
from robot_model import Robot, load_robot


@pytest.fixture(scope="session")
def robot() -> Robot:
    return load_robot("icub")


@pytest.fixture(scope="session")
def server() -> Iterator[PageServer]:
    """A page that no browser looks at."""
    opened = open_server(DashboardConfig())
    yield opened
    opened.stop()


@pytest.fixture
def placement(robot: Robot) -> Placement:
    """The robot at home, its base turned by a quarter about the vertical, 0.6 m up."""
    placed = Placement(robot)
    half = 0.5**0.5
    placed.update(robot.home, np.array([0.0, 0.0, 0.6]), np.array([half, 0.0, 0.0, half]))
    return placed
