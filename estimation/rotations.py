"""Small functions of rotation matrices."""

import math

import numpy as np
import pinocchio as pin


def cross(a: np.ndarray, b: np.ndarray) -> np.ndarray:
    """Return a x b of two vectors (3,); ``np.cross`` costs ten times as much."""
    (ax, ay, az), (bx, by, bz) = a.tolist(), b.tolist()
    return np.array([ay * bz - az * by, az * bx - ax * bz, ax * by - ay * bx])


def heading_of(rotation: np.ndarray) -> float:
    """Return the angle [rad] of the x axis of R_world_frame in the horizontal plane."""
    return float(np.arctan2(rotation[1, 0], rotation[0, 0]))


def rotation_vector(vector: np.ndarray) -> np.ndarray:
    """Return the rotation matrix (3, 3) of a rotation vector (3,) [rad] (Rodrigues)."""
    x, y, z = vector.tolist()
    angle = math.sqrt(x * x + y * y + z * z)
    skew = np.array([[0.0, -z, y], [z, 0.0, -x], [-y, x, 0.0]])
    if angle < 1e-6:
        return np.eye(3) + skew + 0.5 * skew @ skew
    first, second = math.sin(angle) / angle, (1.0 - math.cos(angle)) / angle**2
    return np.eye(3) + first * skew + second * skew @ skew


def orthonormal(rotation: np.ndarray) -> np.ndarray:
    """Return the rotation without the drift of repeated products (one Newton step)."""
    return 1.5 * rotation - 0.5 * rotation @ rotation.T @ rotation


def rotation_of(quat_wxyz: np.ndarray) -> np.ndarray:
    """Return the matrix (3, 3) of a quaternion wxyz (4,), normalised here."""
    w, x, y, z = quat_wxyz / np.linalg.norm(quat_wxyz)
    return np.array(
        [
            [1 - 2 * (y * y + z * z), 2 * (x * y - w * z), 2 * (x * z + w * y)],
            [2 * (x * y + w * z), 1 - 2 * (x * x + z * z), 2 * (y * z - w * x)],
            [2 * (x * z - w * y), 2 * (y * z + w * x), 1 - 2 * (x * x + y * y)],
        ]
    )


def wrap(angle: float) -> float:
    """Return an angle [rad] in (-pi, pi]."""
    return float(np.arctan2(np.sin(angle), np.cos(angle)))


def quaternion_of(rotation: np.ndarray) -> np.ndarray:
    """Return the unit quaternion wxyz (4,) of a rotation matrix (3, 3)."""
    x, y, z, w = pin.Quaternion(rotation).normalized().coeffs()
    return np.array([w, x, y, z])
