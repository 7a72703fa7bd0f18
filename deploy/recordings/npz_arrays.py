"""Reading an npz of arrays over time, and what is checked of each array."""

import zipfile
from collections.abc import Iterable, Mapping
from pathlib import Path

import numpy as np

from deploy.errors import UsageError
from robot_model import Robot
from robot_model.names import did_you_mean

Array = np.ndarray
OF_JOINTS = ("q", "dq", "ddq", "motor_torque")
OF_IMU = ("imu_gyro", "imu_acc", "imu_dgyro")


def load_arrays(file: Path) -> dict[str, Array]:
    """Return the arrays of an npz; UsageError when it is none."""
    try:
        # opened here: numpy leaves a spoilt file open
        with file.open("rb") as stream, np.load(stream, allow_pickle=False) as archive:
            return {name: archive[name] for name in archive.files}
    except (OSError, ValueError, EOFError, zipfile.BadZipFile, AttributeError) as error:
        raise UsageError(f"{file}: not an npz of plain arrays: {error}") from None


def require(arrays: Mapping[str, Array], names: Iterable[str], file: Path) -> None:
    """Raise UsageError for the first array that is not there."""
    for name in names:
        if name not in arrays:
            raise UsageError(f"{file}: no array {name!r}; it has {', '.join(arrays)}")


def checked_stamps(stamp: Array, file: Path) -> Array:
    """Return stamps (T,) int64 ns; UsageError when they do not rise strictly."""
    if stamp.ndim != 1 or stamp.dtype.kind not in "iu" or not len(stamp):
        got = f"{stamp.dtype} {stamp.shape}"
        raise UsageError(f"{file}: stamp: expected (T,) integers [ns], got {got}")
    if stamp[0] < 0:
        raise UsageError(f"{file}: stamp: expected 0 or more, got {stamp[0]} at index 0")
    stamp = stamp.astype(np.int64)
    check_rising(stamp, file)
    return stamp


def check_rising(stamp: Array, file: Path) -> None:
    """Raise UsageError where stamps (T,) do not rise strictly."""
    falls = np.flatnonzero(np.diff(stamp) <= 0)
    if len(falls):
        where = int(falls[0]) + 1
        got = f"{stamp[where]} after {stamp[where - 1]} at index {where}"
        raise UsageError(f"{file}: stamp: expected rising, got {got}")


def joint_rows(arrays: Mapping[str, Array], robot: Robot, file: Path) -> Array:
    """Return the indices in the robot's order of the columns' joints."""
    names = arrays.get("joint_names", np.array(robot.joints)).ravel().astype(str).tolist()
    for name in names:
        if name not in robot.joints:
            hint = did_you_mean(name, robot.joints)
            raise UsageError(f"{file}: joint_names: {robot.name} has no joint {name}{hint}")
    if len(set(names)) != len(names):
        twice = next(name for name in names if names.count(name) > 1)
        raise UsageError(f"{file}: joint_names: {twice} is there twice")
    return np.array([robot.joints.index(name) for name in names])


def checked_numbers(array: Array, name: str, shape: tuple[int, ...], file: Path) -> Array:
    """Return an array as float64; UsageError when its shape or type is another."""
    if array.shape != shape or array.dtype.kind not in "fiu":
        raise UsageError(
            f"{file}: {name}: expected {shape} numbers, got {array.dtype} {array.shape}"
        )
    return array.astype(float)
