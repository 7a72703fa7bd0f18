"""What no sensor of a robot says: not finite, or in other units than those declared."""

from pathlib import Path

import numpy as np

from deploy.errors import UsageError
from deploy.recordings.foreign.plausibility import DEGREES, GYRO, implausible_positions
from estimation.offline.sensor_log import SensorLog
from robot_model import Robot

Array = np.ndarray
SHOWN = 3  # joints that are named
DEGREE = 180.0 / np.pi
FASTEST = 20e3  # Hz; more is no sensor, but another unit of time
WEIGHTLESS = 2.0  # m/s^2


def check_finite(values: Array, name: str, channels: tuple[str, ...], file: Path) -> None:
    """Raise UsageError where an array (T, w) is not finite; ``channels`` (w,) name columns."""
    bad = ~np.isfinite(values)
    if not bad.any():
        return
    row, column = np.argwhere(bad)[0].tolist()
    where = f"index {row}" + (f", {channels[column]}" if channels else "")
    count = int(bad.any(axis=1).sum())
    raise UsageError(
        f"{file}: {name}: expected finite numbers, got {values[row, column]} at {where}"
        f" ({count} of {len(values)} samples)"
    )


def check_units(log: SensorLog, robot: Robot, file: Path) -> list[str]:
    """Raise UsageError for units that look wrong; return warnings of what is merely odd.

    Degrees in the place of radians, g in that of m/s^2, and times that are not ns.
    """
    rate = 1.0 / log.period
    if rate > FASTEST:
        raise UsageError(f"{file}: stamp: expected ns, got steps that mean {rate:.3g} Hz")
    odd = implausible_positions(log.q, np.arange(robot.n), robot)
    if turned := [found.text for found in odd if found.like_degrees]:
        more = f" (and {len(turned) - SHOWN} more joints)" if len(turned) > SHOWN else ""
        raise UsageError(f"{file}: q: {'; '.join(turned[:SHOWN])}{more}")
    _check_velocities(log, file)
    _check_source(log, file)
    return [f"{file}: q: {found.text}" for found in odd]


def _check_velocities(log: SensorLog, file: Path) -> None:
    """Compare velocities with the change of positions, where there is one."""
    if log.dq is None or len(log) < 3:
        return
    seconds = (log.stamp[2:] - log.stamp[:-2])[:, None] * 1e-9
    change = (log.q[2:] - log.q[:-2]) / seconds
    energy = float((change**2).sum())
    ratio = float((change * log.dq[1:-1]).sum()) / energy if energy > 0.0 else 1.0
    if 0.5 * DEGREE < ratio < 2.0 * DEGREE:
        raise UsageError(f"{file}: dq: {ratio:.3g} times as fast as q changes: {DEGREES}")


def _check_source(log: SensorLog, file: Path) -> None:
    peak = float(np.abs(log.imu_gyro).max())
    if peak > GYRO:
        raise UsageError(f"{file}: imu_gyro: up to {peak:.3g} rad/s: {DEGREES}")
    usual = float(np.median(np.linalg.norm(log.imu_acc[:, 0], axis=1)))
    if 0.0 < usual < WEIGHTLESS:
        raise UsageError(
            f"{file}: imu_acc: expected proper acceleration [m/s^2], 9.81 at rest, got"
            f" {usual:.3g}: are these multiples of g, or is gravity taken off?"
        )
