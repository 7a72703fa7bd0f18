"""A robot's URDF in MuJoCo, with exact force/torque and inertial sensors."""

import xml.etree.ElementTree as ElementTree
from importlib import import_module
from typing import Any

import numpy as np
import pinocchio as pin

from robot_model import Robot

mujoco: Any = import_module("mujoco")  # its names come from C, unknown to type checkers


def bare_spec(robot: Robot) -> Any:
    """The robot clamped to the world, without shapes; sensors are named as in its description."""
    spec = mujoco.MjSpec.from_string(_bare_urdf(robot))
    for name, element, placement in zip(
        robot.ft_sensors, robot.ft_elements, robot.ft_placements, strict=True
    ):
        joint = robot.urdf.joints[element.joint]
        add_force_torque(spec, name, joint.child, joint.origin.inverse() * placement)
    return spec


def add_force_torque(spec, name: str, link: str, link_m_sensor: pin.SE3) -> None:
    """Add a sensor of what the link's parent exerts on it, in the sensor's frame."""
    add_site(spec, name, link, link_m_sensor)
    for kind in (mujoco.mjtSensor.mjSENS_FORCE, mujoco.mjtSensor.mjSENS_TORQUE):
        _add_sensor(spec, f"{name}_{kind}", kind, name)


def add_imu(spec, robot: Robot, name: str) -> None:
    """Add gyro, proper and angular acceleration (world axes), nine numbers."""
    link, link_m_imu = robot.frame(name)
    add_site(spec, name, link, link_m_imu)
    kinds = mujoco.mjtSensor.mjSENS_GYRO, mujoco.mjtSensor.mjSENS_ACCELEROMETER
    for kind in (*kinds, mujoco.mjtSensor.mjSENS_FRAMEANGACC):
        _add_sensor(spec, f"{name}_{kind}", kind, name)


def add_rotors(spec, robot: Robot) -> None:
    """Add the rotor inertia A = L L^T: column by column, tendons where joints are coupled."""
    for i, column in enumerate(np.linalg.cholesky(robot.rotor_inertia).T):
        moved = np.flatnonzero(column)
        if len(moved) == 1:
            spec.joint(robot.joints[i]).armature = float(column[i] ** 2)
            continue
        tendon = spec.add_tendon(name=f"rotor_{i}", armature=1.0)
        for j in moved:
            tendon.wrap_joint(robot.joints[j], float(column[j]))


def add_site(spec, name: str, link: str, placement: pin.SE3) -> None:
    spec.body(link).add_site(name=name, **pose(placement))


def pose(placement: pin.SE3) -> dict[str, np.ndarray]:
    """Position and quaternion wxyz, as MuJoCo names them."""
    x, y, z, w = pin.Quaternion(placement.rotation).coeffs()
    return {"pos": placement.translation, "quat": np.array([w, x, y, z])}


def add_force(data, link: str, point_world, force_world, moment_world=(0.0, 0.0, 0.0)) -> None:
    """Add a force and a moment on a link; needs the placements of the present state."""
    body = data.body(link)
    moment = pin.skew(point_world - body.xipos) @ force_world
    data.xfrc_applied[body.id, :3] += force_world
    data.xfrc_applied[body.id, 3:] += moment_world + moment


def _add_sensor(spec, name: str, kind, site: str) -> None:
    spec.add_sensor(name=name, type=kind, objtype=mujoco.mjtObj.mjOBJ_SITE, objname=site)


def _bare_urdf(robot: Robot) -> str:
    """The URDF without shapes, damping and vendor tags; fixed links stay bodies."""
    root = ElementTree.parse(robot.urdf.path).getroot()
    for link in root.findall("link"):
        for tag in ("visual", "collision"):
            for element in link.findall(tag):
                link.remove(element)
    for joint in root.findall("joint"):
        for tag in ("dynamics", "limit"):
            for element in joint.findall(tag):
                joint.remove(element)
        if joint.get("type") == "revolute":
            joint.set("type", "continuous")
    for tag in ("gazebo", "sensor", "transmission"):
        for element in root.findall(tag):
            root.remove(element)
    options = ElementTree.SubElement(root, "mujoco")
    ElementTree.SubElement(options, "compiler", fusestatic="false", discardvisual="false")
    return ElementTree.tostring(root, encoding="unicode")
