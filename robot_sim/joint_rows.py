"""All joints' quantities of one kind as one array."""

import numpy as np
import pinocchio as pin

Array = np.ndarray


def joint_rows(
    quantities: pin.StdVec_SE3 | pin.StdVec_Motion | pin.StdVec_Force,
) -> Array:
    """Return a view (joints, 12) of placements, or (joints, 6) of motions or forces.

    A placement's row is its rotation column by column, then its translation. Pinocchio
    keeps the quantities of all joints in one block, and an attribute of one of its
    objects costs more than a product of small matrices.
    """
    first = quantities[0]
    start, width = (first.rotation, 12) if isinstance(first, pin.SE3) else (first.vector, 6)
    size = start.itemsize
    return np.lib.stride_tricks.as_strided(start, (len(quantities), width), (width * size, size))
