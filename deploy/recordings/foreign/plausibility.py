"""Values that no robot of this kind has: degrees where radians are declared, wrong joints."""

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np

from deploy.recordings.foreign.problems import Problems
from deploy.recordings.foreign.tracks import Track
from robot_model import Robot

SLACK = 0.5  # rad beyond a joint's limits
TURN = 2.0 * np.pi  # rad
GYRO = 30.0  # rad/s; five turns per second of a humanoid's body
DEGREES = "are these degrees? Radians are declared"


class Implausible(NamedTuple):
    """One channel that cannot be right."""

    text: str
    like_degrees: bool


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
    for found in implausible_positions(track.values, track.rows, robot, track.degrees):
        problems.warn(found.text)


def implausible_positions(
    values: np.ndarray, rows: np.ndarray, robot: Robot, degrees: bool = False
) -> list[Implausible]:
    """Return what is odd about positions (T, w) [rad] of the joints ``rows`` (w,).

    Args:
        values: Positions, at least one sample.
        rows: Indices of the joints.
        robot: Whose limits count.
        degrees: They were declared to be degrees, and have been converted.
    """
    lower, upper = robot.position_lower[rows], robot.position_upper[rows]
    smallest, largest = values.min(axis=0), values.max(axis=0)
    median = np.median(values, axis=0)
    turned = np.maximum(abs(smallest), abs(largest)) > TURN
    outside = _beyond(median, lower, upper)
    fits = ~_beyond(np.radians(median), lower, upper)
    odd = []
    for index in np.flatnonzero(turned | outside):
        limits = f"limits {lower[index]:.3g} to {upper[index]:.3g} rad"
        between = f"{smallest[index]:.3g} to {largest[index]:.3g} rad, {limits}"
        like_degrees = bool(fits[index]) and not degrees
        why = DEGREES if like_degrees else "beyond the joint's limits"
        text = f"position of {robot.joints[rows[index]]}: {between}: {why}"
        odd.append(Implausible(text, like_degrees))
    return odd


def _beyond(position: np.ndarray, lower: np.ndarray, upper: np.ndarray) -> np.ndarray:
    return (position < lower - SLACK) | (position > upper + SLACK)
