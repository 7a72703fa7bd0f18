"""Boards: the three modes, limits, and the watchdog."""

import numpy as np
import pytest

from robot_sim import Plant, PlantConfig
from robot_sim.boards import Boards


@pytest.fixture
def boards(robot):
    return Boards(robot, 1e-3)


def test_before_any_command_the_home_posture_is_held(robot, boards):
    assert boards.torque(robot.home, np.zeros(robot.n)) == pytest.approx(np.zeros(robot.n))


def test_position_mode_is_pd_plus_feed_forward(robot, boards):
    feedforward = np.linspace(-0.5, 0.5, robot.n)
    boards.command("position", robot.home, feedforward)
    q, dq = robot.home + 0.01, np.full(robot.n, 0.1)
    expected = -0.01 * robot.board_kp - 0.1 * robot.board_kd + feedforward
    limited = np.clip(expected, -robot.torque_limit, robot.torque_limit)
    assert boards.torque(q, dq) == pytest.approx(limited)


def test_torques_and_references_stay_within_limits(robot, boards):
    boards.command("position", np.full(robot.n, 10.0))
    assert (boards.reference == robot.position_upper).all()
    torque = boards.torque(robot.home, np.zeros(robot.n))
    assert (np.abs(torque) <= robot.torque_limit).all()


def test_velocity_mode_moves_the_reference(robot, boards):
    velocity = np.zeros(robot.n)
    velocity[0] = 0.2
    for _ in range(100):
        boards.command("velocity", velocity)
        boards.torque(robot.home, np.zeros(robot.n))
    assert boards.reference[0] == pytest.approx(robot.home[0] + 0.02)


def test_torque_mode_applies_the_torque(robot, boards):
    torque = np.linspace(-1.0, 1.0, robot.n)
    boards.command("torque", torque)
    assert boards.torque(robot.home, np.zeros(robot.n)) == pytest.approx(torque)


def test_silence_fades_the_feed_forward_after_50_ms_over_half_a_second(robot, boards):
    feedforward = np.full(robot.n, 0.1)
    boards.command("position", robot.home, feedforward)
    torques = [boards.torque(robot.home, np.zeros(robot.n))[0] for _ in range(600)]
    assert torques[48] == pytest.approx(0.1)
    assert torques[299] == pytest.approx(0.05, abs=1e-3)
    assert torques[560] == 0.0


def test_silence_in_torque_mode_becomes_a_hold_at_the_present_posture(robot, boards):
    boards.command("torque", np.full(robot.n, 0.5))
    q = robot.home + 0.02
    for _ in range(60):
        torque = boards.torque(q, np.zeros(robot.n))
    assert boards.mode == "position"
    assert boards.reference == pytest.approx(np.clip(q, robot.position_lower, robot.position_upper))
    assert torque == pytest.approx(np.zeros(robot.n))


@pytest.mark.parametrize(
    ("command", "text"),
    [
        (("position", np.zeros(3)), "position command must be 32 finite numbers, got shape"),
        (("torque", np.full(32, np.nan)), "torque command must be 32 finite numbers"),
        (("position", np.zeros(32), np.zeros(31)), "feed-forward command must be 32"),
        (("impedance", np.zeros(32)), "mode must be one of position, velocity, torque"),
    ],
)
def test_a_wrong_command_is_refused(boards, command, text):
    before = boards.reference
    with pytest.raises(ValueError, match=text):
        boards.command(*command)
    assert boards.reference is before


def test_a_robot_whose_feed_forward_fades_stays_up(robot):
    plant = Plant(robot, config=PlantConfig(watchdog=True))
    for _ in range(1500):
        plant.command(robot.home, plant.truth().link_torque)
        plant.step()
    for _ in range(4000):
        plant.step()
    assert not plant.fallen
    assert np.abs(plant.dq).max() < 0.05
