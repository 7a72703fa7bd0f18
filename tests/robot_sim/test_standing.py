"""The robot stands, is pushed and falls like a body."""

import numpy as np
import pytest

from robot_sim import Plant


def run(plant, seconds):
    for _ in range(round(seconds * 1000)):
        plant.step()


def centre_of_pressure(wrench):
    """Centre of pressure (x, y) of a sole's wrench on the sole's lowest face, sole frame."""
    fx, fy, fz, mx, my, _ = wrench
    height = -0.0105
    return np.array([-my + height * fx, mx + height * fy]) / fz


@pytest.fixture
def standing(robot):
    plant = Plant(robot)
    run(plant, 2.0)
    return plant


@pytest.mark.timeout(600)  # ten seconds of an idle processor, minutes of a busy one
def test_stands_for_a_minute_with_margin(robot):
    plant = Plant(robot)
    run(plant, 60.0)
    truth = plant.truth()
    assert not truth.fallen
    assert np.abs(truth.dq).max() < 1e-6
    for name, wrench in zip(truth.support_frames, truth.support_wrench, strict=True):
        corners = robot.soles[name]
        x, y = centre_of_pressure(wrench)
        # A centimetre and a half from every edge: a push of 10 N moves it by less.
        assert corners[:, 0].min() + 0.015 < x < corners[:, 0].max() - 0.015
        assert corners[:, 1].min() + 0.015 < y < corners[:, 1].max() - 0.015


def test_the_floor_carries_the_weight(standing):
    vertical = standing.truth().support_wrench[:, 2].sum()
    assert vertical == pytest.approx(standing.robot.mass * 9.81, rel=2e-3)


def test_stands_with_the_realistic_profile_and_friction(robot):
    plant = Plant(robot, profile="realistic_friction", seed=1)
    run(plant, 5.0)
    assert not plant.fallen


@pytest.mark.parametrize("direction", [(1, 0, 0), (-1, 0, 0), (0, 1, 0)])
@pytest.mark.parametrize(("force", "falls"), [(50.0, False), (150.0, True)])
def test_a_short_push_on_the_chest_topples_the_robot_only_when_hard(
    standing, direction, force, falls
):
    standing.push("chest", np.zeros(3), force * np.array(direction), "world", "half_sine", 0.2)
    run(standing, 3.0)
    assert standing.fallen == falls


def test_a_fallen_robot_is_frozen_until_reset(standing):
    standing.push("chest", np.zeros(3), np.array([200.0, 0, 0]), "world", "hold", 0.2)
    run(standing, 2.0)
    first = standing.truth()
    run(standing, 0.1)
    later = standing.truth()
    assert first.fallen and later.fallen
    assert np.array_equal(first.q, later.q) and not later.dq.any() and not later.pushes
    assert np.isfinite(later.ft).all() and np.isfinite(standing.raw().imu_acc).all()
    standing.reset()
    run(standing, 1.0)
    assert not standing.fallen


def test_gravity_torque_as_feed_forward_straightens_the_robot(standing):
    sagged = np.abs(standing.q - standing.robot.home)
    for _ in range(3000):
        standing.command(standing.robot.home, standing.truth().link_torque)
        standing.step()
    straight = np.abs(standing.q - standing.robot.home)
    assert sagged.max() > 0.05
    assert straight.max() < 0.01


def test_on_the_pole_the_pole_carries_everything(robot):
    plant = Plant(robot, base="fixed")
    start = plant.truth()
    run(plant, 5.0)
    truth = plant.truth()
    assert truth.support_frames == ["root_link"]
    assert truth.support_wrench[0, 2] == pytest.approx(robot.mass * 9.81, rel=1e-3)
    assert np.array_equal(truth.base_position, start.base_position)
    assert not truth.base_twist.any() and not truth.base_acceleration.any()


def test_base_changes_put_the_robot_on_the_pole_and_back(robot):
    plant = Plant(robot)
    floor = plant.truth().base_position
    plant.base("fixed")
    run(plant, 0.1)
    assert plant.truth().base_position[2] == pytest.approx(floor[2] + plant.config.pole_lift)
    plant.base("free")
    run(plant, 1.0)
    assert plant.truth().support_frames == ["l_sole", "r_sole"]
    assert not plant.fallen
