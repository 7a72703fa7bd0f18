"""Robots that the tests of robot_model share."""

from pathlib import Path

import numpy as np
import pinocchio as pin
import pytest

from robot_model import Robot, load_robot

DATA = Path(__file__).parent / "data"


@pytest.fixture(scope="session")
def icub() -> Robot:
    return load_robot("icub")


@pytest.fixture(scope="session")
def tiny() -> Robot:
    """A robot whose joint order, merged links and sensor differ from iCub's in every way."""
    return load_robot(DATA / "arm.yaml")


@pytest.fixture(scope="session")
def talos(tmp_path_factory: pytest.TempPathFactory) -> Robot:
    """TALOS, described from its URDF alone: sensors at the wrists, no sensor elements."""
    file = tmp_path_factory.mktemp("talos") / "talos.yaml"
    file.write_text((DATA / "talos.yaml").read_text())
    return load_robot(file)


@pytest.fixture(scope="session", params=["icub", "tiny", "talos"])
def robot(request: pytest.FixtureRequest) -> Robot:
    return request.getfixturevalue(request.param)


@pytest.fixture
def random() -> np.random.Generator:
    return np.random.default_rng(7)


class Motion:
    """A random motion of a robot on which nothing from outside acts but gravity."""

    def __init__(self, robot: Robot, random: np.random.Generator):
        tree = robot.tree
        self.tree, self.data = tree, tree.model.createData()
        self.q = random.uniform(-1.0, 1.0, robot.n)
        self.dq, self.ddq = random.normal(size=(2, robot.n))
        pose = pin.SE3(pin.exp3(random.normal(size=3)), random.normal(size=3))
        self.configuration = tree.configuration(self.q, pose)
        self.velocity = tree.velocity(self.dq, random.normal(size=6))
        self.acceleration = tree.velocity(self.ddq, self._free_base_acceleration())
        motion = self.configuration, self.velocity, self.acceleration
        self.torque = pin.rnea(tree.model, self.data, *motion)
        pin.forwardKinematics(tree.model, self.data, *motion)
        pin.updateFramePlacements(tree.model, self.data)

    def _free_base_acceleration(self) -> np.ndarray:
        """Acceleration at which no wrench is needed to hold the base."""
        still = self.tree.velocity(self.ddq)
        motion = self.configuration, self.velocity, still
        wrench = pin.rnea(self.tree.model, self.data, *motion)[:6]
        inertia = pin.crba(self.tree.model, self.data, self.configuration)[:6, :6]
        inertia = np.triu(inertia) + np.triu(inertia, 1).T
        return np.linalg.solve(inertia, -wrench)

    def of(self, frame: str) -> tuple[pin.SE3, np.ndarray, np.ndarray]:
        """Pose, twist and spatial acceleration of a frame, in its axes."""
        index = self.tree.frame_id(frame)
        twist = pin.getFrameVelocity(self.tree.model, self.data, index)
        acceleration = pin.getFrameAcceleration(self.tree.model, self.data, index)
        return self.data.oMf[index], twist.vector, acceleration.vector


@pytest.fixture
def make_motion(random: np.random.Generator):
    return lambda robot: Motion(robot, random)
