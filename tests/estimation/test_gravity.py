"""Gravity compensation: balance on paper, and the standing robot with it."""

import numpy as np
import pinocchio as pin
import pytest

from estimation.gravity import GravityCompensator, LoadSharing
from estimation.rotations import rotation_of
from estimation.support_wrenches import share_support, sole_box
from robot_sim import Plant

SHARING_TIME = 0.25  # s


def hold(plant: Plant, seconds: float, known_load: bool = True) -> np.ndarray:
    """Run the plant with feed-forward at 100 Hz; return the error of each joint at the end."""
    support = "floor" if plant.base_mode == "free" else "pole"
    compensator = GravityCompensator(plant.robot, support, SHARING_TIME)
    for _ in range(int(seconds * 100)):
        truth = plant.truth()
        rotation = rotation_of(truth.base_quat_wxyz)
        force = truth.support_wrench[:, :3] if known_load else None
        result = compensator.step(truth.q, rotation, force, 0.01)
        assert result.reason == ""
        plant.command(feedforward=result.torque)
        for _ in range(10):
            plant.step()
    return np.abs(plant.truth().q - plant.robot.home)


def test_without_compensation_the_shoulder_sags(robot):
    plant = Plant(robot)
    for _ in range(5000):
        plant.step()
    error = np.abs(plant.truth().q - robot.home)
    assert error[robot.joints.index("l_shoulder_yaw")] > 0.05


@pytest.mark.parametrize("known_load", [True, False])
def test_a_standing_robot_keeps_every_joint_within_a_hundredth_of_a_radian(robot, known_load):
    assert hold(Plant(robot), 5.0, known_load).max() < 0.01


def test_on_the_pole_gravity_compensation_is_exact(robot):
    assert hold(Plant(robot, base="fixed"), 5.0).max() < 1e-3


def test_after_a_push_the_compensated_robot_comes_back(robot):
    plant = Plant(robot)
    hold(plant, 1.0)
    plant.push("chest", np.zeros(3), np.array([0.0, 40.0, 0.0]), "world", "half_sine", 0.2)
    hold(plant, 5.0)
    assert not plant.fallen
    assert np.abs(plant.truth().dq).max() < 0.2


@pytest.mark.parametrize("tilt", [np.zeros(3), np.array([0.03, -0.05, 2.0])])
def test_support_wrenches_hold_the_base_and_press_inside_the_soles(robot, tilt):
    compensator = GravityCompensator(robot, "floor", SHARING_TIME)
    result = compensator.step(robot.home, pin.exp3(tilt), None, 0.01)
    up = result.support_wrench[:, 2]
    assert up.sum() == pytest.approx(robot.mass * 9.81, rel=0.01)
    for frame, wrench in zip(compensator.supports, result.support_wrench, strict=True):
        center = np.array([-wrench[4], wrench[3]]) / wrench[2]
        corners = robot.soles[frame][:, :2]
        assert (center > corners.min(axis=0)).all() and (center < corners.max(axis=0)).all()


def test_measured_loads_are_followed_and_an_unknown_one_is_halved():
    sharing = LoadSharing(2, SHARING_TIME)
    for _ in range(400):
        sharing.update(np.array([240.0, 80.0]), 0.01)
    np.testing.assert_allclose(sharing.shares, [0.75, 0.25], atol=1e-3)
    for _ in range(400):
        sharing.update(None, 0.01)
    np.testing.assert_allclose(sharing.shares, [0.5, 0.5], atol=1e-3)


SOLE = np.array([[0.1, 0.05, 0.0], [0.1, -0.05, 0.0], [-0.1, -0.05, 0.0], [-0.1, 0.05, 0.0]])


def two_soles(x: float, y: float) -> tuple[np.ndarray, np.ndarray]:
    """Balance of soles at y = 0.1 and -0.1 m, and the demand of 100 N at (x, y)."""
    maps = np.tile(np.eye(6), (2, 1, 1))
    for i, side in enumerate((0.1, -0.1)):
        maps[i, 3:, :3] = [[0.0, 0.0, side], [0.0, 0.0, 0.0], [-side, 0.0, 0.0]]
    return np.hstack(list(maps)), np.array([0.0, 0.0, 100.0, 100.0 * y, -100.0 * x, 0.0])


def centers(wrench):
    return np.stack([-wrench[:, 4], wrench[:, 3]], axis=1) / wrench[:, 2:3]


@pytest.mark.parametrize(("x", "y"), [(0.0, 0.0), (0.05, 0.02), (0.09, 0.0), (0.0, 0.12)])
def test_shared_wrenches_balance_with_centres_of_pressure_inside(x, y):
    balance, demand = two_soles(x, y)
    result = share_support(balance, demand, np.array([0.5, 0.5]), [sole_box(SOLE)] * 2)
    assert result.feasible
    np.testing.assert_allclose(balance @ result.wrench.ravel(), demand, atol=1e-8)
    loaded = result.wrench[:, 2] > 1.0
    assert (np.abs(centers(result.wrench[loaded])) < [0.1, 0.05]).all()


def test_the_vertical_force_follows_the_shares_while_the_soles_allow_it():
    balance, demand = two_soles(0.0, 0.02)
    result = share_support(balance, demand, np.array([0.7, 0.3]), [sole_box(SOLE)] * 2)
    np.testing.assert_allclose(result.wrench[:, 2], [70.0, 30.0], atol=2.0)


@pytest.mark.parametrize(("x", "y"), [(0.2, 0.0), (0.0, 0.3), (-0.15, -0.2)])
def test_a_centre_of_mass_beyond_the_soles_cannot_be_held(x, y):
    balance, demand = two_soles(x, y)
    result = share_support(balance, demand, np.array([0.5, 0.5]), [sole_box(SOLE)] * 2)
    assert not result.feasible


@pytest.mark.parametrize(("x", "y", "feasible"), [(0.05, 0.02, True), (0.15, 0.2, False)])
def test_one_sole_holds_what_lies_above_it_and_nothing_else(x, y, feasible):
    demand = np.array([0.0, 0.0, 100.0, 100.0 * y, -100.0 * x, 0.0])
    result = share_support(np.eye(6), demand, np.ones(1), [sole_box(SOLE)])
    assert result.feasible == feasible


def test_without_a_support_there_is_nothing_to_hold_against(robot):
    result = GravityCompensator(robot, "none", SHARING_TIME).step(robot.home, np.eye(3), None, 0.01)
    assert result.reason == "no support" and not result.torque.any()
