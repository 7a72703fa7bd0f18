"""An npz as INTERFACES pins it for ``wrenchbus estimate`` (docs/estimate.md)."""

from collections.abc import Mapping
from pathlib import Path

import numpy as np

from deploy.errors import UsageError
from deploy.estimate.given import Given
from deploy.estimate.sanity import check_finite, check_units
from deploy.recordings.npz_arrays import (
    OF_IMU,
    OF_JOINTS,
    checked_numbers,
    checked_stamps,
    joint_rows,
    load_arrays,
    require,
)
from estimation.offline.fixed_link import fixed_readings, rooted_at, without_drives
from estimation.offline.sensor_log import SensorLog
from robot_model import Robot
from robot_model.names import did_you_mean

Array = np.ndarray
TORQUES = ("motor_torque", "link_torque")
AXES = ("x", "y", "z", "mx", "my", "mz")
GRAVITY = (0.0, 0.0, -9.81)  # m/s^2
OTHERS = ("stamp", "joint_names", "fixed_link", "gravity", "base_quat_wxyz", "link_torque")


def read_npz(file: Path, robot: Robot) -> Given:
    """Return the log in an npz.

    Raises:
        UsageError: An array is missing, unknown, of another shape or type, not finite, or
            in other units; the text names it.
    """
    arrays = load_arrays(file)
    _check_names(arrays, robot, file)
    require(arrays, ("stamp", "q"), file)
    return _Reader(file, arrays, robot).read()


def _check_names(arrays: Mapping[str, Array], robot: Robot, file: Path) -> None:
    sensors = [f"ft_{sensor}" for sensor in robot.ft_sensors]
    known = (*OF_JOINTS, *OF_IMU, *OTHERS, *sensors)
    for name in arrays:
        if name not in known:
            hint = did_you_mean(name, sensors if name.startswith("ft_") else known)
            raise UsageError(f"{file}: {name}: no array of this name is known{hint}")


class _Reader:
    """Turns the arrays of one file into a log, each checked."""

    def __init__(self, file: Path, arrays: Mapping[str, Array], robot: Robot):
        self._file, self._arrays, self._robot = file, arrays, robot
        self._stamp = checked_stamps(arrays["stamp"], file)
        self._size = len(self._stamp)
        self._warnings: list[str] = []

    def read(self) -> Given:
        robot, size = self._robot, self._size
        joints, torque = self._joints(), self._torque()
        ft, ft_valid = self._force_torque()
        source, robot = self._source()
        log = SensorLog(
            stamp=self._stamp,
            ft=ft,
            ft_valid=ft_valid,
            joint_valid=np.ones((size, robot.n), dtype=bool),
            imu_valid=np.ones((size, 1), dtype=bool),
            base_quat_wxyz=self._base(),
            motor_torque=joints.get(torque),
            **{kind: joints[kind] for kind in ("q", "dq", "ddq") if kind in joints},
            **source,
        )
        if (log.dq is None) != (log.ddq is None):
            lone = "dq" if log.ddq is None else "ddq"
            self._warnings.append(f"{lone}: not used, dq and ddq are taken together only")
        self._warnings += check_units(log, robot, self._file)
        if torque == "link_torque":
            robot = without_drives(robot)
        return Given(log, robot, self._warnings)

    def _numbers(self, name: str, width: int, channels: tuple[str, ...] = ()) -> Array:
        values = checked_numbers(self._arrays[name], name, (self._size, width), self._file)
        check_finite(values, name, channels, self._file)
        return values

    def _joints(self) -> dict[str, Array]:
        """Return what is given of the joints, in the robot's order."""
        rows, joints = joint_rows(self._arrays, self._robot, self._file), self._robot.joints
        if len(rows) != len(joints):
            missing = ", ".join(name for i, name in enumerate(joints) if i not in rows)
            raise UsageError(
                f"{self._file}: joint_names: expected all {len(joints)} joints of"
                f" {self._robot.name}, got {len(rows)}, without {missing}"
            )
        names = tuple(joints[row] for row in rows)
        order = np.argsort(rows)
        kinds = [kind for kind in ("q", "dq", "ddq", *TORQUES) if kind in self._arrays]
        return {kind: self._numbers(kind, len(rows), names)[:, order] for kind in kinds}

    def _torque(self) -> str:
        """Return which torques are used, "" for none."""
        given = [kind for kind in TORQUES if kind in self._arrays]
        if len(given) > 1:
            self._warnings.append(f"{given[1]}: not used, {given[0]} is there too")
        return given[0] if given else ""

    def _force_torque(self) -> tuple[Array, Array]:
        """Return readings (T, k, 6), and which sensors are there (T, k)."""
        sensors = self._robot.ft_sensors
        ft, valid = np.zeros((self._size, len(sensors), 6)), np.zeros(len(sensors), dtype=bool)
        for index, sensor in enumerate(sensors):
            if name := f"ft_{sensor}" if f"ft_{sensor}" in self._arrays else "":
                ft[:, index], valid[index] = self._numbers(name, 6, AXES), True
        if missing := [sensors[i] for i in np.flatnonzero(~valid)]:
            self._warnings.append(f"no ft_{', ft_'.join(missing)}: what depends on it is invalid")
        return ft, np.tile(valid, (self._size, 1))

    def _source(self) -> tuple[dict[str, Array], Robot]:
        """Return the motion of the kinematic source, and the robot rooted there."""
        if "fixed_link" in self._arrays:
            return self._fixed_link()
        if "gravity" in self._arrays:
            raise UsageError(f"{self._file}: gravity: expected together with fixed_link")
        for name in ("imu_gyro", "imu_acc"):
            if name not in self._arrays:
                raise UsageError(
                    f"{self._file}: no array {name!r}, and no 'fixed_link' in its place;"
                    f" it has {', '.join(self._arrays)}"
                )
        if not self._robot.imus:
            raise UsageError(f"{self._file}: {self._robot.name} has no inertial sensor")
        names = [name for name in OF_IMU if name in self._arrays]
        readings = {name: self._numbers(name, 3, AXES)[:, None] for name in names}
        return readings, rooted_at(self._robot, self._robot.imus[0])

    def _fixed_link(self) -> tuple[dict[str, Array], Robot]:
        array = self._arrays["fixed_link"]
        if array.size != 1 or array.dtype.kind != "U":
            got = f"{array.dtype} {array.shape}"
            raise UsageError(f"{self._file}: fixed_link: expected the name of a link, got {got}")
        try:
            robot = rooted_at(self._robot, str(array.item()))
        except LookupError as error:
            raise UsageError(f"{self._file}: fixed_link: {error.args[0]}") from None
        gravity = checked_numbers(
            self._arrays.get("gravity", np.array(GRAVITY)), "gravity", (3,), self._file
        )
        check_finite(gravity[None], "gravity", AXES, self._file)
        if given := [name for name in OF_IMU if name in self._arrays]:
            self._warnings.append(f"{', '.join(given)}: not used, fixed_link takes their place")
        return fixed_readings(gravity, self._size), robot

    def _base(self) -> Array | None:
        if "base_quat_wxyz" not in self._arrays:
            return None
        quaternions = self._numbers("base_quat_wxyz", 4)
        norms = np.linalg.norm(quaternions, axis=1)
        if (worst := int(np.abs(norms - 1.0).argmax())) >= 0 and abs(norms[worst] - 1.0) > 0.01:
            got = f"{norms[worst]:.3g} at index {worst}"
            raise UsageError(f"{self._file}: base_quat_wxyz: expected length 1, got {got}")
        return quaternions
