"""Readings at the end of a sensor's range, which are no measurements."""

from collections.abc import Iterable
from dataclasses import replace

import numpy as np

from robot_model import Robot
from robot_model.messages import RawFrame, SensorFrame

Array = np.ndarray
FT_AXES = [(f"{kind}{axis}", unit) for kind, unit in (("f", "N"), ("m", "N m")) for axis in "xyz"]
IMU_AXES = [("gyro " + axis, "rad/s") for axis in "xyz"]
IMU_AXES += [("acceleration " + axis, "m/s^2") for axis in "xyz"]


class Saturation:
    """Takes saturated sensors out of raw frames, and remembers why they are missing.

    Args:
        robot: Supplies the ranges of force/torque and inertial sensors; a sensor whose
            range is not in the description is never saturated.
    """

    def __init__(self, robot: Robot):
        self._robot, self._ft, self._imus = robot, robot.ft_sensors, robot.imus
        gyro, acceleration = robot.imu_range[:, :3], robot.imu_range[:, 3:]
        self._range = np.concatenate((robot.ft_range, gyro, acceleration), axis=None)
        self._active = bool(np.isfinite(self._range).any())
        self._faults: dict[str, str] = {}

    def take_out(self, raw: RawFrame) -> RawFrame:
        """Return the frame with saturated sensors flagged as invalid, and zero.

        Force/torque readings are in the convention of Wrenchbus; all values are finite.
        """
        if not self._active:
            return raw
        values = np.concatenate((raw.ft, raw.imu_gyro, raw.imu_acc), axis=None)
        if (np.abs(values) < self._range).all():
            return raw
        return self._masked(raw, np.abs(values) >= self._range)

    def explain(self, frame: SensorFrame) -> SensorFrame:
        """Return the frame with the reasons of those sensors that are invalid since they saturated.

        A sensor that was saturated stays invalid until a window of it has been measured
        again; so does its reason.
        """
        if not self._faults:
            return frame
        names = self._ft + self._imus
        valid = np.concatenate((frame.ft_valid, frame.imu_valid))
        lost = {name for name, is_valid in zip(names, valid, strict=True) if not is_valid}
        self._faults = {name: why for name, why in self._faults.items() if name in lost}
        return replace(frame, faults=[f"{name}: {why}" for name, why in self._faults.items()])

    def _masked(self, raw: RawFrame, saturated: Array) -> RawFrame:
        k, m = len(self._ft), len(self._imus)
        ft = saturated[: 6 * k].reshape(k, 6)
        imu = np.concatenate(saturated[6 * k :].reshape(2, m, 3), axis=1)
        self._note(self._ft, ft, self._robot.ft_range, FT_AXES)
        self._note(self._imus, imu, self._robot.imu_range, IMU_AXES)
        in_ft = ~np.logical_or.reduce(ft, axis=1)
        in_imu = ~np.logical_or.reduce(imu, axis=1)
        return replace(
            raw,
            ft=np.where(in_ft[:, None], raw.ft, 0.0),
            imu_gyro=np.where(in_imu[:, None], raw.imu_gyro, 0.0),
            imu_acc=np.where(in_imu[:, None], raw.imu_acc, 0.0),
            ft_valid=raw.ft_valid & in_ft,
            imu_valid=raw.imu_valid & in_imu,
        )

    def _note(
        self, names: tuple[str, ...], saturated: Array, ranges: Array, axes: list[tuple[str, str]]
    ) -> None:
        for sensor, axis in np.argwhere(saturated)[::-1].tolist():  # the first axis stays
            channel, unit = axes[axis]
            limit = f"{channel} reached {ranges[sensor, axis]:g} {unit}"
            self._faults[names[sensor]] = f"saturated ({limit})"


def faults_by_name(faults: Iterable[str]) -> dict[str, str]:
    """Return a sensor frame's faults, ``name: why``, by the names."""
    return {name: why for name, _, why in (fault.partition(": ") for fault in faults)}
