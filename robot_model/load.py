"""Loading a robot: reading its description, checking it, putting the robot together."""

from pathlib import Path

import numpy as np

from robot_model.body_graph import RigidBody, Subtree, rigid_bodies, subtree_frames
from robot_model.checks import find_problems, ft_element
from robot_model.description import (
    Description,
    InertialRange,
    description_file,
    find_urdf,
    read_description,
)
from robot_model.errors import DescriptionError
from robot_model.inertial import InertialSensor
from robot_model.robot import Robot
from robot_model.urdf import ForceTorqueElement, Urdf, read_urdf


def load_robot(robot: str | Path = "icub") -> Robot:
    """Load a robot by the name of a packaged description, or by the path of a YAML file.

    Raises:
        DescriptionError: Unknown robot, unreadable file, or a description that does not
            fit its URDF; the error names every mismatch.
    """
    file = description_file(robot)
    description = read_description(file)
    urdf_path, package_dirs = find_urdf(description.urdf, file)
    urdf = read_urdf(urdf_path).with_sensors(row.name for row in description.imus)
    if problems := find_problems(description, urdf):
        raise DescriptionError(f"{file} (URDF {urdf_path})", problems)
    return _assemble(description, urdf.locked(description.locked_joints), file, package_dirs)


def robot_name(robot: str | Path = "icub") -> str:
    """Return the name that a robot's ports bear, which needs no URDF; see ``load_robot``.

    Raises:
        DescriptionError: Unknown robot, or a description that cannot be read.
    """
    return read_description(description_file(robot)).name


def _assemble(description: Description, urdf: Urdf, file: Path, package_dirs: list[Path]) -> Robot:
    rows, sensors = description.joints, description.ft_sensors
    elements = tuple(ft_element(row, urdf) for row in sensors)
    limits = [urdf.joints[row.name] for row in rows]
    positions = [row.position or (j.lower, j.upper) for row, j in zip(rows, limits, strict=True)]
    lower, upper = np.array(positions, dtype=float).T
    bodies = rigid_bodies(urdf, {element.joint for element in elements})
    return Robot(
        name=description.name,
        source=file,
        urdf=urdf,
        package_dirs=tuple(package_dirs),
        base_link=description.base_link,
        joints=tuple(row.name for row in rows),
        parts=_by_part([row.part for row in rows]),
        ft_sensors=tuple(row.name for row in sensors),
        ft_elements=elements,
        ft_frames=tuple(row.frame or row.name for row in sensors),
        part_sensors=_by_part([row.part for row in sensors]),
        ft_range=np.array([row.range or [np.inf] * 6 for row in sensors]).reshape(-1, 6),
        imu_range=_inertial_ranges(description),
        imus=tuple(row.name for row in description.imus),
        inertial={row.name: InertialSensor(**row.model_dump()) for row in description.imus},
        subtrees=_subtrees(description, urdf, elements, bodies),
        bodies=bodies,
        supports={kind: tuple(frames) for kind, frames in description.supports.items()}
        | {"none": ()},
        soles={frame: np.array(corners) for frame, corners in description.soles.items()},
        touchable_links=tuple(description.touchable_links),
        home=np.array([row.home for row in rows]),
        position_lower=lower,
        position_upper=upper,
        velocity_limit=np.array([r.velocity or urdf.joints[r.name].velocity for r in rows]),
        torque_limit=np.array([r.torque or urdf.joints[r.name].effort for r in rows]),
        rotor_inertia=_rotor_inertia(description),
        viscous=np.array([row.viscous for row in rows]),
        coulomb=np.array([row.coulomb for row in rows]),
        board_kp=np.array([row.kp for row in rows]),
        board_kd=np.array([row.kd for row in rows]),
    )


def _by_part(parts: list[str]) -> dict[str, np.ndarray]:
    names = dict.fromkeys(parts)
    return {name: np.flatnonzero(np.array(parts) == name) for name in names}


def _inertial_ranges(description: Description) -> np.ndarray:
    unknown = InertialRange()
    rows = [description.imu_ranges.get(row.name, unknown) for row in description.imus]
    largest = [[row.gyro or np.inf] * 3 + [row.acceleration or np.inf] * 3 for row in rows]
    return np.array(largest).reshape(-1, 6)


def _rotor_inertia(description: Description) -> np.ndarray:
    inertia = np.diag([row.rotor for row in description.joints])
    names = [row.name for row in description.joints]
    for block in description.rotor_blocks:
        indices = [names.index(name) for name in block.joints]
        inertia[np.ix_(indices, indices)] = block.matrix
    return inertia


def _subtrees(
    description: Description,
    urdf: Urdf,
    elements: tuple[ForceTorqueElement, ...],
    bodies: dict[str, RigidBody],
) -> tuple[Subtree, ...]:
    hangs_on = ["", *(element.joint for element in elements)]
    frames = subtree_frames(urdf, hangs_on[1:])
    rows = [description.root_subtree, *description.ft_sensors]
    names = [description.root_subtree.name, *(row.subtree for row in description.ft_sensors)]
    bearers = {frame: body.name for body in bodies.values() for frame in body.placements}
    subtrees = []
    for index, (row, name, joint) in enumerate(zip(rows, names, hangs_on, strict=True)):
        inside = frames[joint]
        out = [i for i, e in enumerate(elements) if urdf.joints[e.joint].parent in inside]
        links = tuple(main for main in bodies if main in inside)
        bearer = bearers[row.default_frame]
        subtrees.append(
            Subtree(name, row.default_frame, bearer, links, inside, index - 1, tuple(out))
        )
    return tuple(subtrees)
