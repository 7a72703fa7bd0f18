"""Values that look like degrees where radians are declared."""

from collections.abc import Iterable

import numpy as np

from deploy.recordings.foreign.problems import Problems
from deploy.recordings.foreign.tracks import Track
from robot_model import Robot

SLACK = 0.5  # rad beyond a joint's limits
TURN = 2.0 * np.pi  # rad
GYRO = 30.0  # rad/s; five turns per second of a humanoid's body


def look_for_degrees(tracks: Iterable[Track], robot: Robot, problems: Problems) -> None:
    """Warn of each channel whose values would be plausible as degrees, and not as radians."""
    for track in tracks:
        if not len(track.times):
            continue
        if track.kind == "q":
            _joints(track, robot, problems)
        elif track.kind == "imu_gyro" and np.abs(track.values).max() > GYRO:
            peak = np.abs(track.values).max()
            _warn(problems, f"gyro of {track.names[0]}", f"{peak:.3g} rad/s")


def _joints(track: Track, robot: Robot, problems: Problems) -> None:
    lower, upper = robot.position_lower[track.rows], robot.position_upper[track.rows]
    smallest, largest = track.values.min(axis=0), track.values.max(axis=0)
    median = np.median(track.values, axis=0)
    turned = np.maximum(abs(smallest), abs(largest)) > TURN
    outside = (median < lower - SLACK) | (median > upper + SLACK)
    degrees = np.radians(median)
    fits = (degrees >= lower - SLACK) & (degrees <= upper + SLACK)
    for index in np.flatnonzero((turned | outside) & fits):
        limits = f"limits {lower[index]:.3g} to {upper[index]:.3g} rad"
        between = f"{smallest[index]:.3g} to {largest[index]:.3g} rad, {limits}"
        _warn(problems, f"position of {track.names[index]}", between)


def _warn(problems: Problems, channel: str, values: str) -> None:
    problems.warn(f"{channel}: {values}: are these degrees? The log is declared to be in radians")
