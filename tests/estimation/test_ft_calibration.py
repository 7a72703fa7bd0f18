"""Secondary matrix and temperature: reading = S raw - c (T - T0)."""

import numpy as np
import pytest

from estimation.ft_calibration import FtCalibration

SECOND = 1_000_000_000
EVERY = np.ones(2, dtype=bool)


@pytest.fixture
def slopes():
    return np.array([[0.1, 0.0, 0.3, 0.0, 0.01, 0.0], [0.0] * 6])


@pytest.fixture
def calibration(slopes):
    maps = np.array([2.0 * np.eye(6), np.eye(6)[::-1]])
    return FtCalibration(maps, slopes, np.array([25.0, 25.0]), hold=10.0)


def test_matrix_and_temperature_correct_each_sensor(calibration, slopes):
    raw = np.arange(12.0).reshape(2, 6)
    reading = calibration.apply(raw, np.array([35.0, 60.0]), EVERY, 0)
    np.testing.assert_allclose(reading[0], 2.0 * raw[0] - 10.0 * slopes[0])
    np.testing.assert_allclose(reading[1], raw[1, ::-1])


def test_the_last_temperature_serves_for_a_while_and_then_the_sensor_lacks_one(calibration, slopes):
    raw = np.zeros((2, 6))
    np.testing.assert_array_equal(calibration.lacking(0), [True, False])
    calibration.apply(raw, np.array([30.0, 0.0]), EVERY, SECOND)
    held = calibration.apply(raw, None, EVERY, 11 * SECOND)
    np.testing.assert_allclose(held[0], -5.0 * slopes[0])
    assert not calibration.lacking(11 * SECOND).any()
    np.testing.assert_array_equal(calibration.lacking(12 * SECOND), [True, False])
    np.testing.assert_array_equal(calibration.lacking(0), [True, False])  # the clock jumped back


@pytest.mark.parametrize(("value", "good"), [(np.nan, True), (90.0, False)])
def test_a_temperature_that_is_invalid_is_not_taken(calibration, slopes, value, good):
    calibration.apply(np.zeros((2, 6)), np.array([30.0, 0.0]), EVERY, 0)
    reading = calibration.apply(
        np.zeros((2, 6)), np.array([value, 0.0]), np.array([good, True]), SECOND
    )
    np.testing.assert_allclose(reading[0], -5.0 * slopes[0])
    assert calibration.lacking(11 * SECOND)[0]


def test_without_coefficients_nobody_lacks_a_temperature():
    calibration = FtCalibration(np.eye(6)[None], np.zeros((1, 6)), np.array([25.0]), 1.0)
    assert calibration.lacking(0) is None
