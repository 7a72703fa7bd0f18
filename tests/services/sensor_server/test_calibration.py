"""The calibration of the specimens, in the driver's axes, before everything else."""

import numpy as np
import pytest
from pydantic import ValidationError

from robot_model.ft_convention import from_wrenchbus, to_wrenchbus
from robot_model.messages import RawFrame
from services.sensor_server.calibration import Calibrated
from services.sensor_server.config import FtConfig, FtSensorConfig

SLOPE = (0.1, 0.0, 0.2, 0.0, 0.0, 0.01)


def frame(robot, ft, temperature=None, good=None):
    n, k, m = (robot.dimensions[letter] for letter in "nkm")
    return RawFrame(
        q=np.zeros(n),
        ft=ft,
        imu_gyro=np.zeros((m, 3)),
        imu_acc=np.zeros((m, 3)),
        joint_valid=np.ones(n, dtype=bool),
        ft_valid=np.ones(k, dtype=bool),
        imu_valid=np.ones(m, dtype=bool),
        ft_temperature=temperature,
        ft_temperature_valid=good,
    )


def config(**sensor):
    return FtConfig(sensors={"l_leg_ft": FtSensorConfig(**sensor)}, temperature_hold=10.0)


def test_without_calibration_a_frame_passes_untouched(robot):
    raw = frame(robot, np.ones((6, 6)))
    assert Calibrated(robot, "wrenchbus", FtConfig())(raw, 0) is raw


def test_the_calibration_comes_before_the_convention_of_the_driver(robot):
    rng = np.random.default_rng(0)
    truth, matrix = rng.normal(size=(6, 6)), np.eye(6) + 0.05 * rng.normal(size=(6, 6))
    leg = robot.ft_sensors.index("l_leg_ft")
    delivered = from_wrenchbus(robot, truth)
    delivered[leg] = np.linalg.solve(matrix, delivered[leg] + 12.0 * np.array(SLOPE))
    settings = config(matrix=matrix.tolist(), temperature=SLOPE, reference=20.0)
    raw = frame(robot, delivered, np.full(6, 32.0))
    read = Calibrated(robot, "urdf", settings)(raw, 0)
    np.testing.assert_allclose(read.ft, truth, atol=1e-9)
    assert np.abs(to_wrenchbus(robot, delivered)[leg] - truth[leg]).max() > 0.1


def test_a_sensor_that_needs_a_temperature_and_gets_none_is_invalid_and_named(robot):
    calibrated = Calibrated(robot, "wrenchbus", config(temperature=SLOPE))
    leg = robot.ft_sensors.index("l_leg_ft")
    blind = calibrated(frame(robot, np.ones((6, 6))), 0)
    assert calibrated.lacking == ["l_leg_ft"]
    assert np.flatnonzero(~blind.ft_valid).tolist() == [leg] and not blind.ft[leg].any()
    good = np.ones(6)
    seen = calibrated(frame(robot, np.ones((6, 6)), np.full(6, 35.0), good), 1)
    assert seen.ft_valid.all() and calibrated.lacking == []
    np.testing.assert_allclose(seen.ft[leg], 1.0 - 10.0 * np.array(SLOPE))
    good[leg] = 0.0
    late = frame(robot, np.ones((6, 6)), np.full(6, 99.0), good)
    assert calibrated(late, 9_000_000_000).ft_valid.all()
    assert not calibrated(late, 11_000_000_000).ft_valid[leg]


def test_wrong_calibrations_are_refused_with_what_is_wrong(robot):
    unknown = FtConfig(sensors={"l_leg": FtSensorConfig()})
    with pytest.raises(ValueError, match="no sensor 'l_leg'; did you mean 'l_leg_ft'"):
        Calibrated(robot, "wrenchbus", unknown)
    with pytest.raises(ValidationError, match="expected a regular 6x6 matrix"):
        FtSensorConfig(matrix=np.zeros((6, 6)).tolist())
    with pytest.raises(ValidationError, match="matrix"):
        FtSensorConfig(matrix=np.eye(5).tolist())
    with pytest.raises(ValidationError, match="finite"):
        FtSensorConfig(temperature=[np.nan] * 6)


def test_the_servers_frames_and_status_follow_a_calibration_given_at_run_time(bench, robot):
    bench.node.ready()
    ft = {name: {"matrix": (2.0 * np.eye(6)).tolist()} for name in robot.ft_sensors}
    old = bench.server._config
    settings = FtConfig.model_validate({"sensors": ft})
    bench.server._configure(old, old.model_copy(update={"ft": settings}))
    bench.step(ft=np.full((6, 6), 3.0))
    np.testing.assert_allclose(bench.server.frames.frame.ft, 6.0)
    assert bench.server.status()["ft_without_temperature"] == []
