"""Force/torque readings as drivers deliver them, and as Wrenchbus carries them.

Inside Wrenchbus a reading is what the parent side exerts on the child side, about
the origin and in the axes of the URDF frame that bears the sensor's name. A driver
follows the sensor's element of the URDF: ``<measure_direction>`` says who exerts the
wrench on whom, ``<frame>`` in whose axes it is written (parent, child, or the
sensor's own ``<origin>``, which is relative to the child); the moment is about the
joint's origin, which is the child's.
"""

import numpy as np
import pinocchio as pin

from robot_model.robot import Robot
from robot_model.urdf import ForceTorqueElement, Joint


def raw_to_wrenchbus(robot: Robot) -> np.ndarray:
    """Return the map from raw readings to Wrenchbus readings of each sensor, (k, 6, 6).

    Wrenches are [fx fy fz mx my mz]; ``reading[i] = matrices[i] @ raw[i]``.
    """
    maps = [
        _sign(element) * (placement.inverse() * _parent_m_raw(element, joint)).toDualActionMatrix()
        for element, placement, joint in _sensors(robot)
    ]
    return np.array(maps).reshape(-1, 6, 6)


def to_wrenchbus(robot: Robot, raw: np.ndarray) -> np.ndarray:
    """Convert raw readings (k, 6) or (T, k, 6) of a driver to Wrenchbus readings."""
    return np.einsum("kij,...kj->...ki", raw_to_wrenchbus(robot), raw)


def from_wrenchbus(robot: Robot, readings: np.ndarray) -> np.ndarray:
    """Convert Wrenchbus readings (k, 6) or (T, k, 6) to what a driver would deliver."""
    return np.einsum("kij,...kj->...ki", np.linalg.inv(raw_to_wrenchbus(robot)), readings)


def _sensors(robot: Robot) -> list[tuple[ForceTorqueElement, pin.SE3, Joint]]:
    joints = [robot.urdf.joints[element.joint] for element in robot.ft_elements]
    return list(zip(robot.ft_elements, robot.ft_placements, joints, strict=True))


def _sign(element: ForceTorqueElement) -> float:
    return -1.0 if element.measure_direction == "child_to_parent" else 1.0


def _parent_m_raw(element: ForceTorqueElement, joint: Joint) -> pin.SE3:
    """Placement in the parent link of the frame in which raw readings are written."""
    if element.frame == "parent":
        return pin.SE3(np.eye(3), joint.origin.translation)
    if element.frame == "sensor":
        return joint.origin * element.origin
    return joint.origin  # child: the sensor's own <origin> does not count
