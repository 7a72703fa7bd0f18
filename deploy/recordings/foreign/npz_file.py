"""An npz of arrays over time, in the form that ``wrenchbus estimate`` reads (docs/recordings.md).

``stamp`` (T,) int64 ns strictly rising; ``q`` (T, n) rad, in the description's order of joints or
that of ``joint_names``; optional ``dq``, ``ddq``, ``motor_torque`` (T, n); ``ft_<sensor>`` (T, 6);
``imu_gyro``, ``imu_acc``, ``imu_dgyro`` (T, 3). Samples that are not finite are left out.
"""

import zipfile
from collections.abc import Mapping
from pathlib import Path

import numpy as np

from bus.names import did_you_mean
from deploy.errors import UsageError
from deploy.recordings.foreign.problems import Problems
from deploy.recordings.foreign.tracks import Track
from robot_model import Robot

Array = np.ndarray
OF_JOINTS = ("q", "dq", "ddq", "motor_torque")
OF_IMU = ("imu_gyro", "imu_acc", "imu_dgyro")
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
    arrays = _load(file)
    for name in ("stamp", "q"):
        if name not in arrays:
            raise UsageError(f"{file}: no array {name!r}; it has {', '.join(arrays)}")
    times = _stamps(arrays["stamp"], file)
    joints = _joint_rows(arrays, robot, file)
    tracks = []
    for name, array in arrays.items():
        if name in NO_CHANNEL:
            problems.warn(f"{file}: {name} is not imported: {NO_CHANNEL[name]}")
        elif name in OF_JOINTS:
            values = _checked(array, name, (len(times), len(joints)), file)
            names = tuple(robot.joints[row] for row in joints)
            tracks.append(_finite(Track(name, names, joints, times, values), file, problems))
        elif name in OF_IMU or name.startswith("ft_"):
            tracks.append(_finite(_sensor(name, array, times, robot, file), file, problems))
        elif name not in ("stamp", "joint_names"):
            problems.warn(f"{file}: {name} is not known, and not imported")
    return tracks


def _load(file: Path) -> dict[str, Array]:
    try:
        with np.load(file, allow_pickle=False) as archive:
            return {name: archive[name] for name in archive.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile, AttributeError) as error:
        raise UsageError(f"{file}: not an npz of plain arrays: {error}") from None


def _stamps(stamp: Array, file: Path) -> Array:
    if stamp.ndim != 1 or stamp.dtype.kind not in "iu" or not len(stamp):
        got = f"{stamp.dtype} {stamp.shape}"
        raise UsageError(f"{file}: stamp: expected (T,) integers [ns], got {got}")
    stamp = stamp.astype(np.int64)
    falls = np.flatnonzero(np.diff(stamp) <= 0)
    if len(falls) or stamp[0] < 0:
        where = int(falls[0]) + 1 if len(falls) else 0
        got = f"{stamp[where]} at index {where}"
        raise UsageError(f"{file}: stamp: expected rising from 0 or more, got {got}")
    return stamp


def _joint_rows(arrays: Mapping[str, Array], robot: Robot, file: Path) -> Array:
    names = [str(name) for name in arrays.get("joint_names", np.array(robot.joints))]
    for name in names:
        if name not in robot.joints:
            hint = did_you_mean(name, robot.joints)
            raise UsageError(f"{file}: joint_names: {robot.name} has no joint {name}{hint}")
    if len(set(names)) != len(names):
        raise UsageError(f"{file}: joint_names: a joint is there twice")
    return np.array([robot.joints.index(name) for name in names])


def _sensor(name: str, array: Array, times: Array, robot: Robot, file: Path) -> Track:
    sensor = robot.imus[0] if name in OF_IMU and robot.imus else name.removeprefix("ft_")
    known = robot.imus if name in OF_IMU else robot.ft_sensors
    if sensor not in known:
        hint = did_you_mean(sensor, known) or f" (it has {', '.join(known)})"
        raise UsageError(f"{file}: {name}: {robot.name} has no sensor {sensor}{hint}")
    width = 3 if name in OF_IMU else 6
    values = _checked(array, name, (len(times), width), file)[:, None, :]
    kind = name if name in OF_IMU else "ft"
    return Track(kind, (sensor,), np.array([known.index(sensor)]), times, values)


def _checked(array: Array, name: str, shape: tuple[int, ...], file: Path) -> Array:
    if array.shape != shape or array.dtype.kind not in "fiu":
        raise UsageError(
            f"{file}: {name}: expected {shape} numbers, got {array.dtype} {array.shape}"
        )
    return array.astype(float)


def _finite(track: Track, file: Path, problems: Problems) -> Track:
    """Return a track without the samples that are not finite."""
    flat = track.values.reshape(len(track.times), -1)
    good = np.isfinite(flat).all(axis=1)
    for index in np.flatnonzero(~good).tolist():
        problems.line(f"{file}[{track.kind} {track.names[0]}]", index, "not a finite number")
    return Track(track.kind, track.names, track.rows, track.times[good], track.values[good])
