"""Streams of a log as numbers of the robot: SI units, Wrenchbus's signs and frames."""

from dataclasses import dataclass, replace

import numpy as np

from deploy.recordings.foreign.map_file import Convention, ForceTorque, Imu, Joints, Stream
from robot_model import Robot
from robot_model.ft_convention import raw_to_wrenchbus

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class Track:
    """Samples of some channels of one kind.

    ``kind`` is a field of RawFrame; ``rows`` are the indices of joints or sensors in it.
    ``degrees``: they were declared to be degrees, and have been converted.
    """

    kind: str
    names: tuple[str, ...]
    rows: Array  # (w,)
    times: Array  # (T,) ns, strictly rising
    values: Array  # (T, w, …) as in RawFrame
    degrees: bool = False

    @property
    def period(self) -> float:
        """Median time between samples [ns]; 0 with fewer than two."""
        return float(np.median(np.diff(self.times))) if len(self.times) > 1 else 0.0


def tracks_of(stream: Stream, times: Array, values: Array, robot: Robot) -> list[Track]:
    """Return the tracks of a stream.

    Args:
        stream: What the numbers are.
        times: (T,) ns, strictly rising.
        values: (T, at least stream.width), as in the log.
        robot: Whose channels they are.
    """
    if stream.ft is not None:
        return [_force_torque(stream.ft, times, values[:, :6], robot)]
    if stream.imu is not None:
        return _inertial(stream.imu, times, values, robot)
    return [_joints(stream.target, getattr(stream, stream.target), times, values, robot)]


def _joints(kind: str, joints: Joints, times: Array, values: Array, robot: Robot) -> Track:
    columns = [index for index, name in enumerate(joints.joints) if name is not None]
    names = tuple(name for name in joints.joints if name is not None)
    rows = np.array([robot.joints.index(name) for name in names])
    chosen, degrees = values[:, columns], joints.unit == "deg"
    return Track(kind, names, rows, times, np.radians(chosen) if degrees else chosen, degrees)


def _force_torque(ft: ForceTorque, times: Array, values: Array, robot: Robot) -> Track:
    row = robot.ft_sensors.index(ft.sensor)
    converted = values @ _conversion(ft, row, robot).T
    return Track("ft", (ft.sensor,), np.array([row]), times, converted[:, None, :])


def _conversion(ft: ForceTorque, row: int, robot: Robot) -> Array:
    """Return the map from the log's readings to ours, (6, 6)."""
    if ft.convention == "wrenchbus":
        return np.eye(6)
    if isinstance(ft.convention, Convention):
        elements = list(robot.ft_elements)
        elements[row] = replace(elements[row], **ft.convention.model_dump())
        robot = replace(robot, ft_elements=tuple(elements))
    return raw_to_wrenchbus(robot)[row]


def _inertial(imu: Imu, times: Array, values: Array, robot: Robot) -> list[Track]:
    rows = np.array([robot.imus.index(imu.name)])
    acc = values[:, imu.acc_at : imu.acc_at + 3]
    gyro = values[:, imu.gyro_at : imu.gyro_at + 3]
    degrees = imu.gyro_unit == "deg/s"
    gyro = np.radians(gyro) if degrees else gyro
    return [
        Track("imu_acc", (imu.name,), rows, times, acc[:, None, :]),
        Track("imu_gyro", (imu.name,), rows, times, gyro[:, None, :], degrees),
    ]
