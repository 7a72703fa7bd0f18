"""Robots that the tests of the maths share."""

import pytest

from robot_model import Robot, load_robot
from tests.estimation.random_robots import small_icub
from tests.estimation.touched_rows import TouchedRows


@pytest.fixture(scope="session")
def robot() -> Robot:
    return load_robot("icub")


@pytest.fixture(scope="module")
def touched(robot: Robot) -> TouchedRows:
    return TouchedRows(robot)


@pytest.fixture(scope="session", params=["32 joints, 6 sensors", "23 joints, 4 sensors"])
def peer_robot(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Robot:
    if request.param.startswith("32"):
        return load_robot("icub")
    return small_icub(tmp_path_factory.mktemp("small_icub"))
