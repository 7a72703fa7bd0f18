"""What the plant's tests share."""

from collections.abc import Callable

import numpy as np
import pinocchio as pin
import pytest

from robot_model import Robot, load_robot
from robot_sim import Plant


@pytest.fixture(scope="session")
def robot() -> Robot:
    return load_robot("icub")


@pytest.fixture(scope="session")
def thrown() -> Callable[[Plant, int], None]:
    """Put a plant into a random state of motion, feet on, in or above the floor."""

    def throw(plant: Plant, seed: int) -> None:
        random = np.random.default_rng(seed)
        tree, body = plant.robot.tree, plant._body
        lower, upper = plant.robot.position_lower, plant.robot.position_upper
        q = tree.configuration(random.uniform(lower, upper))
        body.v = random.normal(0.0, 1.0, tree.model.nv)
        if plant.base_mode == "free":
            place = pin.SE3(pin.exp3(random.normal(size=3)), random.normal(size=3))
            q[:7] = pin.SE3ToXYZQUAT(place)
        else:
            q[:7] = body.q[:7]
            body.v[:6] = 0.0
        body.q = q
        body.update_kinematics()
        plant._evaluate()

    return throw
