"""Values that no robot of this kind has: degrees where radians are declared, wrong joints."""

from collections.abc import Iterable

import numpy as np

from deploy.recordings.foreign.problems import Problems
from deploy.recordings.foreign.tracks import Track
from robot_model import Robot

SLACK = 0.5  # rad beyond a joint's limits
TURN = 2.0 * np.pi  # rad
GYRO = 30.0  # rad/s; five turns per second of a humanoid's body
DEGREES = "are these degrees? Radians are declared"


def check_plausible(tracks: Iterable[Track], robot: Robot, problems: Problems) -> None:
    """Warn of each channel that looks like degrees where radians are declared.

    And of joints that mostly are beyond their limits. What is near 0 cannot be told.
    """
    for track in tracks:
        if track.kind == "q" and len(track.times):
            _check_joints(track, robot, problems)
        elif track.kind == "imu_gyro" and len(track.times):
            peak = np.abs(track.values).max()
            if peak > GYRO and not track.degrees:
                problems.warn(f"gyro of {track.names[0]}: up to {peak:.3g} rad/s: {DEGREES}")


def _check_joints(track: Track, robot: Robot, problems: Problems) -> None:
    lower, upper = robot.position_lower[track.rows], robot.position_upper[track.rows]
    smallest, largest = track.values.min(axis=0), track.values.max(axis=0)
    median = np.median(track.values, axis=0)
    turned = np.maximum(abs(smallest), abs(largest)) > TURN
    outside = _beyond(median, lower, upper)
    fits = ~_beyond(np.radians(median), lower, upper)
    for index in np.flatnonzero(turned | outside):
        limits = f"limits {lower[index]:.3g} to {upper[index]:.3g} rad"
        between = f"{smallest[index]:.3g} to {largest[index]:.3g} rad, {limits}"
        like_degrees = fits[index] and not track.degrees
        why = DEGREES if like_degrees else "beyond the joint's limits"
        problems.warn(f"position of {track.names[index]}: {between}: {why}")


def _beyond(position: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    return (position < lower - SLACK) | (position > upper + SLACK)
