"""A dump of ``yarpdatadumper``, the map of docs/, and the robot of both."""

import pytest

from robot_model import load_robot
from tests.deploy.foreign_logs.importing import TEXT
from tests.deploy.yarp_dump import write_dump


@pytest.fixture(scope="module")
def robot():
    return load_robot("icub")


@pytest.fixture
def dump(tmp_path):
    return write_dump(tmp_path / "dump")


@pytest.fixture
def fastest(tmp_path):
    """The map of docs/, on the log's own instants."""
    path = tmp_path / "fastest.yaml"
    path.write_text(TEXT)
    return path
