"""An npz of arrays over time, in the form that ``wrenchbus estimate`` reads (docs/recordings.md).

``stamp`` (T,) int64 ns strictly rising; ``q`` (T, n) rad, in the description's order of joints or
that of ``joint_names``; optional ``dq``, ``ddq``, ``motor_torque`` (T, n); ``ft_<sensor>`` (T, 6);
``imu_gyro``, ``imu_acc``, ``imu_dgyro`` (T, 3). Samples that are not finite are left out.
"""

from pathlib import Path

import numpy as np

from bus.names import did_you_mean
from deploy.errors import UsageError
from deploy.recordings.foreign.problems import Problems
from deploy.recordings.foreign.tracks import Track
from deploy.recordings.npz_arrays import (
    OF_IMU,
    OF_JOINTS,
    checked_numbers,
    checked_stamps,
    joint_rows,
    load_arrays,
    require,
)
from robot_model import Robot

Array = np.ndarray
NO_CHANNEL = {
    "link_torque": "a raw frame has motor torques only",
    "fixed_link": "a raw frame has inertial sensors only",
    "gravity": "a raw frame has inertial sensors only",
    "base_quat_wxyz": "a raw frame has no base",
}


def npz_tracks(file: Path, robot: Robot, problems: Problems) -> list[Track]:
    """Return the streams of an npz.

    Raises:
        UsageError: It cannot be read, or an array has another name, shape or type.
    """
    arrays = load_arrays(file)
    require(arrays, ("stamp", "q"), file)
    times = checked_stamps(arrays["stamp"], file)
    joints = joint_rows(arrays, robot, file)
    tracks = []
    for name, array in arrays.items():
        if name in NO_CHANNEL:
            problems.warn(f"{file}: {name} is not imported: {NO_CHANNEL[name]}")
        elif name in OF_JOINTS:
            values = checked_numbers(array, name, (len(times), len(joints)), file)
            names = tuple(robot.joints[row] for row in joints)
            tracks.append(_finite(Track(name, names, joints, times, values), file, problems))
        elif name in OF_IMU or name.startswith("ft_"):
            tracks.append(_finite(_sensor(name, array, times, robot, file), file, problems))
        elif name not in ("stamp", "joint_names"):
            problems.warn(f"{file}: {name} is not known, and not imported")
    return tracks


def _sensor(name: str, array: Array, times: Array, robot: Robot, file: Path) -> Track:
    sensor = robot.imus[0] if name in OF_IMU and robot.imus else name.removeprefix("ft_")
    known = robot.imus if name in OF_IMU else robot.ft_sensors
    if sensor not in known:
        hint = did_you_mean(sensor, known) or f" (it has {', '.join(known)})"
        raise UsageError(f"{file}: {name}: {robot.name} has no sensor {sensor}{hint}")
    width = 3 if name in OF_IMU else 6
    values = checked_numbers(array, name, (len(times), width), file)[:, None, :]
    kind = name if name in OF_IMU else "ft"
    return Track(kind, (sensor,), np.array([known.index(sensor)]), times, values)


def _finite(track: Track, file: Path, problems: Problems) -> Track:
    """Return a track without the samples that are not finite."""
    flat = track.values.reshape(len(track.times), -1)
    good = np.isfinite(flat).all(axis=1)
    for index in np.flatnonzero(~good).tolist():
        problems.line(f"{file}[{track.kind} {track.names[0]}]", index, "not a finite number")
    return Track(track.kind, track.names, track.rows, track.times[good], track.values[good])
