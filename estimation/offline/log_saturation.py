"""Readings of a log at the end of a sensor's range, which are no measurements."""

from dataclasses import replace

import numpy as np

from estimation.offline.sensor_log import SensorLog
from robot_model import Robot


def without_saturated(log: SensorLog, robot: Robot) -> tuple[SensorLog, dict[str, int]]:
    """Return the log with saturated readings invalid, and of how many samples, by sensor.

    As ``estimation.saturation`` does live: a sensor is saturated when any of its axes
    reaches its range in the robot's description.
    """
    imu = np.concatenate((log.imu_gyro, log.imu_acc), axis=2)
    lost_ft = (np.abs(log.ft) >= robot.ft_range).any(axis=2) & log.ft_valid
    lost_imu = (np.abs(imu) >= robot.imu_range).any(axis=2) & log.imu_valid
    counts = np.concatenate((lost_ft, lost_imu), axis=1).sum(axis=0).tolist()
    names = robot.ft_sensors + robot.imus
    told = {name: count for name, count in zip(names, counts, strict=True) if count}
    return (_without(log, lost_ft, lost_imu) if told else log), told


def _without(log: SensorLog, lost_ft: np.ndarray, lost_imu: np.ndarray) -> SensorLog:
    return replace(
        log,
        ft=np.where(lost_ft[:, :, None], 0.0, log.ft),
        imu_gyro=np.where(lost_imu[:, :, None], 0.0, log.imu_gyro),
        imu_acc=np.where(lost_imu[:, :, None], 0.0, log.imu_acc),
        ft_valid=log.ft_valid & ~lost_ft,
        imu_valid=log.imu_valid & ~lost_imu,
    )
