"""The robot of all tests of whole systems."""

import pytest

from robot_model import Robot, load_robot


@pytest.fixture(scope="session")
def robot() -> Robot:
    return load_robot("icub")
