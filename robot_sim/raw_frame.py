"""The raw frame: exact readings made as wrong as the noise profile says."""

from collections.abc import Mapping

import numpy as np
import pinocchio as pin

from robot_model.messages import RawFrame
from robot_sim.noise import Noise
from robot_sim.sensors import Readings

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
        imu_quat_wxyz=_orientation(exact.rotation, error["orientation"]),
        **valid,
    )


def _orientation(rotation: Array, error: Array) -> Array:
    """Return quaternions wxyz (m, 4) of R_world_imu, turned by small errors (m, 3) [rad]."""
    quaternions = np.empty((len(rotation), 4))
    for row, matrix, (ex, ey, ez) in zip(quaternions, rotation, error.tolist(), strict=True):
        turn = pin.Quaternion(1.0, 0.5 * ex, 0.5 * ey, 0.5 * ez)
        turned = pin.Quaternion(matrix) * turn
        turned.normalize()
        row[1:4], row[0] = turned.coeffs()[:3], turned.w
    return quaternions
