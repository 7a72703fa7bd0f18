"""Small functions of rotation matrices."""

import math

import numpy as np
import pinocchio as pin

HALF_AND_ONE = 1.5 * np.eye(3)


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return a x b of two vectors (3,); ``np.cross`` costs ten times as much."""
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def heading_of(rotation: np.ndarray) -> float:
    """Return the angle [rad] of the x axis of R_world_frame in the horizontal plane."""
    return math.atan2(rotation[1, 0], rotation[0, 0])


def rotation_vector(vector: np.ndarray) -> np.ndarray:
    """Return the rotation matrix (3, 3) of a rotation vector (3,) [rad] (Rodrigues)."""
    return pin.exp3(vector)


def orthonormal(rotation: np.ndarray) -> np.ndarray:
    """Return the rotation without the drift of repeated products (one Newton step)."""
    return rotation @ (HALF_AND_ONE - 0.5 * (rotation.T @ rotation))


def rotation_of(quat_wxyz: np.ndarray) -> np.ndarray:
    """Return the matrix (3, 3) of a quaternion wxyz (4,), normalised here."""
    return pin.Quaternion(*quat_wxyz.tolist()).normalized().matrix()


def up_of(quat_wxyz: np.ndarray) -> np.ndarray:
    """Return the world's upward unit vector (3,) in the frame of a quaternion wxyz (4,)."""
    w, x, y, z = quat_wxyz.tolist()
    scale = 2.0 / (w * w + x * x + y * y + z * z)
    return np.array([scale * (x * z - w * y), scale * (y * z + w * x), 1 - scale * (x * x + y * y)])


def wrap(angle: float) -> float:
    """Return an angle [rad] in [-pi, pi]."""
    return math.remainder(angle, math.tau)


def quaternion_of(rotation: np.ndarray) -> np.ndarray:
    """Return the unit quaternion wxyz (4,) of a rotation matrix (3, 3)."""
    x, y, z, w = pin.Quaternion(rotation).normalized().coeffs().tolist()
    return np.array([w, x, y, z])
