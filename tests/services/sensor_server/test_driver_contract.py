"""What every driver must do; add yours to ``HARDWARE`` in conftest.py and run this file."""

import time

import numpy as np
import pytest

from bus.testing import eventually
from robot_model.messages import MotorCommand
from services.sensor_server.config import SensorServerConfig
from services.sensor_server.driver import make_driver

TICK = 1_000_000  # [ns]
PATIENCE = 60.0  # [s]


def read(hardware):
    """Return the next reading, however long it takes to arrive."""
    return eventually(lambda: hardware.driver.read(0.01), PATIENCE)


def test_frames_come_in_order_and_none_is_skipped(hardware):
    for index in range(1, 41):
        hardware.deliver(index * TICK)
    assert [read(hardware).stamp for _ in range(40)] == [i * TICK for i in range(1, 41)]


def test_a_reading_tells_when_it_was_measured_and_by_which_clock(hardware):
    before = time.time_ns()
    hardware.deliver(7 * TICK)
    reading = read(hardware)
    assert reading.stamp == 7 * TICK and reading.clock in (0, 1)
    assert before <= reading.acquired <= time.time_ns()
    assert reading.valid and reading.reason == ""


def test_a_frame_has_the_robots_shapes(hardware, robot):
    hardware.deliver(TICK)
    frame = read(hardware).frame
    n, k, m = (robot.dimensions[letter] for letter in "nkm")
    assert frame.q.shape == frame.joint_valid.shape == (n,)
    assert frame.ft.shape == (k, 6) and frame.ft_valid.shape == (k,)
    assert frame.imu_gyro.shape == frame.imu_acc.shape == (m, 3) and frame.imu_valid.shape == (m,)
    assert frame.joint_valid.dtype == frame.ft_valid.dtype == frame.imu_valid.dtype == bool


def test_a_channel_that_was_not_measured_is_flagged_and_the_others_come(hardware, robot):
    valid = np.arange(robot.n) != 3
    hardware.deliver(TICK, joint_valid=valid)
    frame = read(hardware).frame
    np.testing.assert_array_equal(frame.joint_valid, valid)
    assert frame.ft_valid.all()


def test_velocities_and_accelerations_are_none_when_they_are_not_measured(hardware):
    hardware.deliver(TICK, dq=None, ddq=None, imu_dgyro=None)
    frame = read(hardware).frame
    assert frame.dq is None and frame.ddq is None and frame.imu_dgyro is None


def test_a_read_without_a_frame_ends_in_time(hardware):
    hardware.deliver(TICK)
    read(hardware)
    start = time.monotonic()
    assert hardware.driver.read(0.05) is None
    assert time.monotonic() - start < 20.0


def test_silence_has_a_reason_and_ends_with_the_next_frame(hardware):
    hardware.deliver(TICK)
    read(hardware)
    reason = eventually(lambda: hardware.driver.silence, PATIENCE)
    assert isinstance(reason, str)
    hardware.deliver(2 * TICK)
    read(hardware)
    assert hardware.driver.silence == ""


def test_a_command_reaches_the_boards_as_it_is_or_is_said_to_be_ignored(hardware, robot, caplog):
    hardware.deliver(TICK)
    reading = read(hardware)
    value, torque = np.linspace(-1.0, 1.0, robot.n), np.linspace(0.0, 2.0, robot.n)
    command = MotorCommand(mode="velocity", value=value, feedforward=torque)

    if hardware.commands() is None:  # there are no boards
        hardware.driver.write(command, reading)
        assert hardware.ignored == 1 and "commands are ignored" in caplog.text
        return

    def received():
        hardware.driver.write(command, reading)  # again and again: the link may just come up
        return hardware.commands()

    last = eventually(received, PATIENCE)[-1]
    assert last.mode == "velocity"
    np.testing.assert_array_equal(last.value, value)
    np.testing.assert_array_equal(last.feedforward, torque)


def test_a_driver_that_calls_itself_checked_delivers_no_value_that_is_not_finite(hardware, robot):
    if hardware.driver.checked:
        with pytest.raises(ValueError):
            hardware.deliver(TICK, q=np.full(robot.n, np.nan))
        assert hardware.driver.read(0.05) is None


def test_the_clock_is_not_paused_by_itself(hardware):
    assert hardware.driver.paused is False


def test_the_convention_of_the_force_torque_readings_is_stated(hardware):
    assert hardware.driver.ft_convention in ("wrenchbus", "urdf")


def test_closing_twice_is_closing_once(hardware):
    hardware.driver.close()
    hardware.driver.close()


@pytest.mark.parametrize("name", ["nonsense", "no.such.module:Driver", "services:Driver"])
def test_an_unknown_driver_is_refused_with_what_is_expected(node, robot, name):
    with pytest.raises(
        ValueError, match="expected 'plant', 'replay' or 'package.module:Class', got"
    ):
        make_driver(name, node, robot, SensorServerConfig())
