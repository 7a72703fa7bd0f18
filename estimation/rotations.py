"""Small functions of vectors and rotations.

Those of arrays take and return arrays. Those of ``Vector`` and ``Rows`` work on plain floats,
because one NumPy call costs as much as the whole arithmetic of three numbers, and several
times more in a process that has just slept.
"""

import math
from collections.abc import Sequence

import numpy as np
import pinocchio as pin

Vector = Sequence[float]  # (3,)
Rows = Sequence[Vector]  # (3, 3) rotation matrix
Quaternion = tuple[float, float, float, float]  # wxyz


def add(a: Vector, b: Vector, scale: float = 1.0) -> list[float]:
    """Return a + scale * b."""
    (ax, ay, az), (bx, by, bz) = a, b
    return [ax + scale * bx, ay + scale * by, az + scale * bz]


def dot(a: Vector, b: Vector) -> float:
    """Return a . b."""
    (ax, ay, az), (bx, by, bz) = a, b
    return ax * bx + ay * by + az * bz


def cross(a: Vector, b: Vector) -> list[float]:
    """Return a x b."""
    (ax, ay, az), (bx, by, bz) = a, b
    return [ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx]


def rotate(rotation: Rows, vector: Vector) -> list[float]:
    """Return R v."""
    (a, b, c), (d, e, f), (g, h, i) = rotation
    x, y, z = vector
    return [a * x + b * y + c * z, d * x + e * y + f * z, g * x + h * y + i * z]


def rotate_back(rotation: Rows, vector: Vector) -> list[float]:
    """Return R' v."""
    (a, b, c), (d, e, f), (g, h, i) = rotation
    x, y, z = vector
    return [a * x + d * y + g * z, b * x + e * y + h * z, c * x + f * y + i * z]


def heading_of(axis: Vector) -> float:
    """Return the angle [rad] of a frame's x axis, in world axes, in the horizontal plane."""
    return math.atan2(axis[1], axis[0])


def wrap(angle: float) -> float:
    """Return an angle [rad] in [-pi, pi]."""
    return math.remainder(angle, math.tau)


def multiply(a: Quaternion, b: Quaternion) -> Quaternion:
    """Return the unit quaternion of two rotations, b first; it does not drift."""
    (aw, ax, ay, az), (bw, bx, by, bz) = a, b
    w = aw * bw - ax * bx - ay * by - az * bz
    x = aw * bx + ax * bw + ay * bz - az * by
    y = aw * by - ax * bz + ay * bw + az * bx
    z = aw * bz + ax * by - ay * bx + az * bw
    norm = math.sqrt(w * w + x * x + y * y + z * z)
    return w / norm, x / norm, y / norm, z / norm


def exponential(vector: Vector) -> Quaternion:
    """Return the quaternion of a rotation vector [rad]."""
    x, y, z = vector
    angle = math.sqrt(x * x + y * y + z * z)
    scale = math.sin(0.5 * angle) / angle if angle > 1e-9 else 0.5
    return math.cos(0.5 * angle), scale * x, scale * y, scale * z


def rows_of(quaternion: Quaternion) -> list[list[float]]:
    """Return the matrix of a quaternion of any length; identity for zeros."""
    w, x, y, z = quaternion
    s = 2.0 / max(w * w + x * x + y * y + z * z, 1e-12)
    return [
        [1.0 - s * (y * y + z * z), s * (x * y - w * z), s * (x * z + w * y)],
        [s * (x * y + w * z), 1.0 - s * (x * x + z * z), s * (y * z - w * x)],
        [s * (x * z - w * y), s * (y * z + w * x), 1.0 - s * (x * x + y * y)],
    ]


def rotation_of(quat_wxyz: np.ndarray) -> np.ndarray:
    """Return the matrix (3, 3) of a quaternion wxyz (4,), normalised here."""
    return np.array(rows_of(tuple(quat_wxyz.tolist())))


def quaternion_of(rotation: np.ndarray) -> np.ndarray:
    """Return the unit quaternion wxyz (4,) of a rotation matrix (3, 3)."""
    x, y, z, w = pin.Quaternion(rotation).normalized().coeffs().tolist()
    return np.array([w, x, y, z])
