"""The experiment that counts how often stated intervals hold the truth."""

import numpy as np
import pytest

from experiments import coverage
from experiments.coverage import CENTER, MASS, WINDOW, noise_of
from experiments.wrong_bodies import wrong_bodies
from robot_model import load_robot
from robot_sim.noise import load_profile


@pytest.fixture(scope="module")
def robot():
    return load_robot("icub")


def test_intervals_hold_the_truth_about_as_often_as_they_say(robot):
    """Eight runs are few; docs/experiments.md has 200."""
    held = coverage.run(robot, seed=5, runs=8).figures["held"]["all"]
    assert 0.90 < held["95 %"] < 0.99
    assert held["50 %"] < 0.65


def test_the_noise_of_a_channel_is_that_of_its_profile(robot):
    exact, noisy = (noise_of(load_profile(name), WINDOW) for name in ("ideal", "realistic"))
    assert exact.force == exact.joint_acceleration == exact.angular_acceleration == 0.0
    assert 0.9 < noisy.force < 1.0  # N, half of 2 N of bias; white noise is filtered
    assert (noisy.mass, noisy.center_of_mass) == (MASS, CENTER)


def test_wrong_bodies_are_wrong_by_what_is_asked(robot):
    random = np.random.default_rng(0)
    wrong = [wrong_bodies(robot, random, MASS, CENTER).bodies for _ in range(50)]
    heavy = [name for name, body in robot.bodies.items() if body.inertia.mass > 0.0]
    masses = [
        [b[name].inertia.mass / robot.bodies[name].inertia.mass for name in heavy] for b in wrong
    ]
    centers = [
        [b[name].inertia.lever - robot.bodies[name].inertia.lever for name in heavy] for b in wrong
    ]
    assert abs(np.std(masses) / MASS - 1.0) < 0.1 and abs(np.std(centers) / CENTER - 1.0) < 0.1
    with pytest.raises(ValueError, match="at least 1 run"):
        coverage.run(robot, runs=0)
