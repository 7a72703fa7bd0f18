"""Robots that the tests beside iDynTree share."""

import pytest

from robot_model import Robot, load_robot
from tests.estimation.random_robots import small_icub


@pytest.fixture(scope="session", params=["32 joints, 6 sensors", "23 joints, 4 sensors"])
def peer_robot(request: pytest.FixtureRequest, tmp_path_factory: pytest.TempPathFactory) -> Robot:
    if request.param.startswith("32"):
        return load_robot("icub")
    return small_icub(tmp_path_factory.mktemp("small_icub"))
