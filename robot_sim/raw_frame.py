"""The raw frame: exact readings made as wrong as the noise profile says."""

import math
from collections.abc import Mapping

import numpy as np

from robot_model.messages import RawFrame
from robot_sim.noise import Noise
from robot_sim.sensors import Quaternion, Readings

Array = np.ndarray


def all_valid(dimensions: Mapping[str, int]) -> dict[str, Array]:
    """Return the validity flags of a robot whose sensors all work."""
    names = {"joint_valid": "n", "ft_valid": "k", "imu_valid": "m"}
    return {name: np.ones(dimensions[d], dtype=bool) for name, d in names.items()}


def raw_frame(exact: Readings, noise: Noise, valid: Mapping[str, Array]) -> RawFrame:
    """Return what the driver delivers for exact readings.

    Args:
        exact: Readings of one instant.
        noise: Errors of this tick, and whether boards deliver derivatives.
        valid: Validity flags of the channels.
    """
    error, derivatives = noise.errors, noise.profile.derivatives
    return RawFrame(
        q=noise.encoder(exact.q),
        dq=exact.dq if derivatives else None,
        ddq=exact.ddq if derivatives else None,
        motor_torque=exact.motor_torque + error["motor_torque"],
        ft=exact.ft + error["ft"],
        imu_gyro=exact.gyro + error["gyro"],
        imu_acc=exact.acceleration + error["accelerometer"],
        imu_dgyro=exact.angular_acceleration if derivatives else None,
        imu_quat_wxyz=_orientation(exact.attitude, error["orientation"]),
        **valid,
    )


def _orientation(attitude: list[Quaternion], error: Array) -> Array:
    """Return quaternions wxyz (m, 4) of attitudes turned by small errors (m, 3) [rad]."""
    pairs = zip(attitude, error.tolist(), strict=True)
    return np.array([_turned(exact, *turn) for exact, turn in pairs]).reshape(-1, 4)


def _turned(q: Quaternion, ex: float, ey: float, ez: float) -> Quaternion:
    """Return q (1, e / 2), normalised; in plain floats, where four numbers are cheapest."""
    w, x, y, z = q
    ex, ey, ez = 0.5 * ex, 0.5 * ey, 0.5 * ez
    turned = (
        w - x * ex - y * ey - z * ez,
        x + w * ex + y * ez - z * ey,
        y + w * ey + z * ex - x * ez,
        z + w * ez + x * ey - y * ex,
    )
    norm = math.hypot(*turned)
    return turned[0] / norm, turned[1] / norm, turned[2] / norm, turned[3] / norm
