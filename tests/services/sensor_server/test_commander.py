from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from services.sensor_server.commander import Commander, CommandRefused
from services.sensor_server.config import CommandConfig

ROBOT: Any = SimpleNamespace(
    n=2,
    home=np.array([0.1, -0.1]),
    position_lower=np.array([-1.0, -1.0]),
    position_upper=np.array([1.0, 1.0]),
    velocity_limit=np.array([2.0, 2.0]),
    torque_limit=np.array([5.0, 5.0]),
)
ALL = np.ones(2, dtype=bool)
POSTURE = np.array([0.2, 0.1])
TICK = 0.005  # [s]
ME, OTHER = b"me", b"other"


@pytest.fixture
def commander() -> Commander:
    commander = Commander(ROBOT, CommandConfig())
    commander.measured(POSTURE, ALL)
    return commander


def run(commander: Commander, start: float, stop: float, feed: bool = False) -> None:
    """Advance in ticks; with ``feed``, a feed-forward of 4 N m arrives in each."""
    for now in np.arange(start, stop, TICK):
        if feed:
            commander.feedforward(np.full(2, 4.0), now)
        commander.advance(now)


def test_the_robot_near_home_holds_the_home_posture(commander):
    np.testing.assert_array_equal(commander.motor_command().value, ROBOT.home)
    assert commander.motor_command().mode == "position"


def test_the_robot_far_from_home_holds_where_it_is():
    commander = Commander(ROBOT, CommandConfig())
    commander.measured(np.array([0.9, 0.0]), ALL)
    np.testing.assert_array_equal(commander.motor_command().value, [0.9, 0.0])


def test_nothing_is_commanded_before_every_joint_was_measured():
    commander = Commander(ROBOT, CommandConfig())
    commander.measured(POSTURE, np.array([True, False]))
    assert not commander.ready
    with pytest.raises(CommandRefused, match="no joint positions yet"):
        commander.command("position", np.zeros(2), ME, 0.0)


@pytest.mark.parametrize(("mode", "limit"), [("position", 1.0), ("velocity", 2.0), ("torque", 5.0)])
def test_commands_are_clipped_to_the_limits(commander, mode: str, limit: float):
    commander.command(mode, np.array([100.0, -100.0]), ME, 0.0)
    np.testing.assert_array_equal(commander.motor_command().value, [limit, -limit])


@pytest.mark.parametrize("value", [[np.nan, 0.0], [np.inf, 0.0], [0.0]])
def test_values_that_are_not_a_command_are_refused_and_change_nothing(commander, value):
    before = commander.motor_command()
    with pytest.raises(CommandRefused, match="expected 2 finite numbers"):
        commander.command("torque", np.array(value), ME, 0.0)
    after = commander.motor_command()
    assert after.mode == before.mode and (after.value == before.value).all()


def test_an_unknown_mode_is_refused_with_the_known_ones(commander):
    with pytest.raises(CommandRefused, match="position, velocity, torque, got 'impedance'"):
        commander.command("impedance", np.zeros(2), ME, 0.0)


def test_one_writer_at_a_time_until_it_is_silent(commander):
    commander.command("position", np.zeros(2), ME, 0.0)
    with pytest.raises(CommandRefused, match="lease"):
        commander.command("position", np.ones(2), OTHER, 0.4)
    commander.command("position", np.zeros(2), ME, 0.45)
    with pytest.raises(CommandRefused, match="lease"):
        commander.command("position", np.ones(2), OTHER, 0.9)
    commander.command("position", np.ones(2), OTHER, 0.96)
    np.testing.assert_array_equal(commander.motor_command().value, [1.0, 1.0])


def test_a_refused_writer_does_not_keep_the_owner_out(commander):
    commander.command("position", np.zeros(2), ME, 0.0)
    for now in np.arange(0.1, 0.5, 0.1):
        with pytest.raises(CommandRefused):
            commander.command("position", np.ones(2), OTHER, now)
    commander.command("position", np.ones(2), OTHER, 0.6)


@pytest.mark.parametrize("mode", ["velocity", "torque"])
def test_a_silent_velocity_or_torque_command_ends_in_a_safe_hold(commander, mode: str):
    commander.command(mode, np.ones(2), ME, 1.0)
    commander.measured(np.array([0.5, 0.5]), ALL)
    commander.advance(1.049)
    assert commander.motor_command().mode == mode
    commander.advance(1.051)
    assert commander.changed
    command = commander.motor_command()
    assert command.mode == "position" and (command.value == 0.5).all()
    assert commander.status()["holding"] and f"no {mode} command" in commander.reason


def test_a_position_command_stands_for_ever(commander):
    commander.command("position", np.full(2, 0.7), ME, 0.0)
    commander.advance(100.0)
    assert (commander.motor_command().value == 0.7).all() and not commander.status()["holding"]


def test_a_new_command_ends_a_hold(commander):
    commander.command("torque", np.ones(2), ME, 0.0)
    commander.advance(0.2)
    commander.command("torque", np.ones(2), OTHER, 0.2)  # the hold ended the first one's lease
    assert commander.motor_command().mode == "torque" and not commander.status()["holding"]


def test_the_feedforward_fades_in_and_is_clipped(commander):
    run(commander, 0.0, 0.25, feed=True)
    assert 0.3 < commander.motor_command().feedforward[0] / 4.0 < 0.6
    run(commander, 0.25, 0.6, feed=True)
    assert (commander.motor_command().feedforward == 4.0).all()
    commander.feedforward(np.full(2, 100.0), 0.6)
    assert (commander.motor_command().feedforward == 5.0).all()


def test_the_feedforward_fades_from_50_ms_to_550_ms_after_its_last_message(commander):
    run(commander, 0.0, 1.0, feed=True)  # the last message is at 0.995
    expected = {1.04: 4.0, 1.045 + 0.25: 2.0, 1.045 + 0.5: 0.0, 2.0: 0.0}
    start = 1.0
    for until, torque in expected.items():
        run(commander, start, until)
        start = until
        assert commander.motor_command().feedforward[0] == pytest.approx(torque, abs=0.1)


def test_stop_holds_the_present_posture_and_refuses_until_release(commander):
    run(commander, 0.0, 1.0, feed=True)
    commander.command("torque", np.ones(2), ME, 1.0)
    commander.measured(np.array([0.4, 0.4]), ALL)
    commander.stop("pressed")
    command = commander.motor_command()
    assert command.mode == "position" and (command.value == 0.4).all()
    with pytest.raises(CommandRefused, match="stopped \\(pressed\\); release first"):
        commander.command("position", np.zeros(2), ME, 1.01)
    run(commander, 1.0, 1.6, feed=True)
    assert not commander.motor_command().feedforward.any()
    commander.release()
    assert (commander.motor_command().value == 0.4).all()
    run(commander, 1.6, 2.2, feed=True)
    assert (commander.motor_command().feedforward == 4.0).all()
    commander.command("position", np.zeros(2), OTHER, 2.2)
    assert not commander.motor_command().value.any()


def test_joints_that_are_not_measured_keep_their_last_posture(commander):
    commander.measured(np.array([0.0, 0.6]), np.array([False, True]))
    commander.stop("pressed")
    np.testing.assert_array_equal(commander.motor_command().value, [0.2, 0.6])


def test_new_limits_take_effect_at_once(commander):
    commander.configure(CommandConfig(command_timeout=1.0))
    commander.command("torque", np.ones(2), ME, 0.0)
    commander.advance(0.5)
    assert commander.motor_command().mode == "torque"


def test_a_robot_put_back_to_its_start_holds_home_again_and_stays_stopped(commander):
    commander.measured(np.array([0.9, 0.9]), ALL)
    commander.stop("pressed")
    commander.restart()
    assert not commander.ready
    commander.measured(POSTURE, ALL)
    np.testing.assert_array_equal(commander.motor_command().value, ROBOT.home)
    assert commander.stopped
