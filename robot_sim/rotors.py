"""What the rotors of the motors add to the mass matrix."""

import numpy as np
import pinocchio as pin

from robot_model import Robot

Array = np.ndarray


def added_inertia(robot: Robot, data: pin.Data) -> Array:
    """Return the upper triangle (nv, nv) of what the rotors add to the mass matrix.

    Raises:
        ValueError: rotors couple joints of different branches, where the mass matrix
            has zeros that its factorisation skips.
    """
    at = robot.tree.joint_v
    inertia = np.zeros_like(data.M, order="F")
    inertia[np.ix_(at, at)] = robot.rotor_inertia
    inertia[:] = np.triu(inertia)
    beyond = np.arange(len(inertia)) + data.nvSubtree_fromRow.tolist()
    for row, column in np.argwhere(inertia):
        if column >= beyond[row]:
            names = [robot.joints[at.tolist().index(v)] for v in (row, column)]
            raise ValueError(
                f"{robot.name}: rotor_blocks: expected joints of one chain, got "
                f"{' and '.join(names)} of different branches"
            )
    return inertia
