"""From the readings of a driver to those of Wrenchbus: convention and calibration at once."""

from dataclasses import replace

import numpy as np

from estimation.ft_calibration import FtCalibration
from robot_model import Robot
from robot_model.ft_convention import raw_to_wrenchbus
from robot_model.messages import RawFrame
from robot_model.names import did_you_mean
from services.sensor_server.config import FtConfig, FtSensorConfig
from services.sensor_server.driver import FtConvention


class Calibrated:
    """Converts raw frames; free of cost where there is nothing to convert.

    A sensor that has temperature coefficients and no temperature is invalid.

    Raises:
        ValueError: The settings name a sensor that the robot does not have.
    """

    def __init__(self, robot: Robot, convention: FtConvention, config: FtConfig):
        self._sensors = robot.ft_sensors
        self._calibration = _calibration(robot, convention, config)
        self._every = np.ones(len(self._sensors), dtype=bool)
        self.lacking: list[str] = []  # sensors without the temperature that they need

    def __call__(self, raw: RawFrame, stamp: int) -> RawFrame:
        """Return the frame with its readings as Wrenchbus carries them."""
        if self._calibration is None:
            return raw
        ft = self._calibration.apply(raw.ft, raw.ft_temperature, self._good(raw), stamp)
        lacking = self._calibration.lacking(stamp)
        if lacking is None or not lacking.any():
            self.lacking = []
            return replace(raw, ft=ft)
        self.lacking = [self._sensors[i] for i in np.flatnonzero(lacking)]
        ft[lacking] = 0.0
        return replace(raw, ft=ft, ft_valid=raw.ft_valid & ~lacking)

    def _good(self, raw: RawFrame) -> np.ndarray:
        """Return which temperatures are valid, (k,) bool."""
        flags = raw.ft_temperature_valid
        return self._every if flags is None else flags == 1.0


def _calibration(robot: Robot, convention: FtConvention, config: FtConfig) -> FtCalibration | None:
    """Return the calibration with the convention's maps multiplied in; None for identity."""
    if unknown := set(config.sensors) - set(robot.ft_sensors):
        name = min(unknown)
        raise ValueError(f"ft.sensors: no sensor '{name}'{did_you_mean(name, robot.ft_sensors)}")
    if convention != "urdf" and not config.sensors:
        return None
    rows = [config.sensors.get(name, FtSensorConfig()) for name in robot.ft_sensors]
    maps = raw_to_wrenchbus(robot) if convention == "urdf" else np.array([np.eye(6)] * len(rows))
    slopes = np.array([row.temperature for row in rows])
    return FtCalibration(
        maps @ np.array([row.matrix for row in rows]),
        np.matvec(maps, slopes),
        np.array([row.reference for row in rows]),
        config.temperature_hold,
    )
