"""Does a description fit its URDF? Every mismatch is found and named."""

from collections import Counter
from collections.abc import Iterable, Iterator

import numpy as np

from robot_model.body_graph import RigidBody, rigid_bodies, subtree_frames
from robot_model.description import Description, ForceTorqueRow, InertialRow, JointRow, RotorBlock
from robot_model.names import did_you_mean
from robot_model.urdf import MOVING, ForceTorqueElement, Urdf

UNLIMITED = 1e4  # URDFs write such numbers where a limit is unknown


def find_problems(description: Description, urdf: Urdf) -> list[str]:
    """Return every mismatch between a description and its URDF, one sentence each."""
    problems = [*_names(description), *_joints(description, urdf), *_rotors(description)]
    problems += [*_frames(description, urdf), *_soles(description)]
    sensors = list(_sensors(description, urdf))
    return problems + (sensors or list(_places(description, urdf)))


def ft_element(row: ForceTorqueRow, urdf: Urdf) -> ForceTorqueElement:
    """Return how a sensor's driver reports; when the URDF is silent, child on parent."""
    if row.name in urdf.ft_elements:
        return urdf.ft_elements[row.name]
    return ForceTorqueElement(row.name, row.joint or "")


def _duplicates(names: Iterable[str], what: str) -> Iterator[str]:
    for name, count in Counter(names).items():
        if count > 1:
            yield f"{what} '{name}' is named {count} times"


def _names(description: Description) -> Iterator[str]:
    sensors = description.ft_sensors
    yield from _duplicates([row.name for row in description.joints], "joints:")
    yield from _duplicates([row.name for row in sensors], "ft_sensors:")
    yield from _duplicates([row.name for row in description.imus], "imus:")
    yield from _inertial(description.imus)
    names = [row.name for row in description.imus]
    for name in description.imu_ranges:
        if name not in names:
            yield f"imu_ranges: unknown sensor '{name}'{did_you_mean(name, names)}"
    subtrees = [description.root_subtree.name, *(row.subtree for row in sensors)]
    yield from _duplicates(subtrees, "sub-tree")
    parts = {row.part for row in description.joints}
    for row in sensors:
        if row.part not in parts:
            yield f"ft_sensors.{row.name}: unknown part '{row.part}'{did_you_mean(row.part, parts)}"


def _inertial(rows: list[InertialRow]) -> Iterator[str]:
    for number, row in enumerate(rows):
        if not (row.gyro or row.accelerometer):
            yield f"imus: '{row.name}' measures nothing"
        elif number == 0 and not (row.gyro and row.accelerometer):
            yield f"imus: the first, '{row.name}', must have a gyro and an accelerometer"


def _joints(description: Description, urdf: Urdf) -> Iterator[str]:
    moving = {name for name, joint in urdf.joints.items() if joint.moving}
    listed = {row.name for row in description.joints}
    locked = set(description.locked_joints)
    for name in sorted(listed & locked):
        yield f"joint '{name}' is listed and locked"
    for row in description.joints:
        yield from _joint(row, urdf, moving)
    for name in sorted(locked - moving):
        yield f"locked_joints: unknown moving joint '{name}'{did_you_mean(name, moving)}"
    for name in sorted(moving - listed - locked):
        yield f"joint '{name}' of the URDF is missing: list it or lock it"
    for joint in urdf.joints.values():
        if not joint.moving and joint.type != "fixed":
            yield f"joint '{joint.name}': expected {sorted(MOVING)} or fixed, got '{joint.type}'"


def _joint(row: JointRow, urdf: Urdf, moving: set[str]) -> Iterator[str]:
    if row.name not in moving:
        kind = "fixed" if row.name in urdf.joints else "unknown"
        yield f"joints: {kind} joint '{row.name}'{did_you_mean(row.name, moving)}"
        return
    joint = urdf.joints[row.name]
    lower, upper = row.position or (joint.lower, joint.upper)
    if joint.mimic:
        yield f"joint '{row.name}' mimics another joint in the URDF: lock it"
    if not lower < upper:
        yield f"joint '{row.name}': position limits [{lower:g}, {upper:g}] are not in order"
    elif not lower <= row.home <= upper:
        yield f"joint '{row.name}': home {row.home:g} is outside [{lower:g}, {upper:g}]"
    for key, own, theirs in (
        ("velocity", row.velocity, joint.velocity),
        ("torque", row.torque, joint.effort),
    ):
        if own is None and not 0.0 < theirs < UNLIMITED:
            yield f"joint '{row.name}': no {key} limit here, and the URDF's is {theirs:g}"


def _rotors(description: Description) -> Iterator[str]:
    names = [row.name for row in description.joints]
    yield from _duplicates(
        [name for block in description.rotor_blocks for name in block.joints], "rotor_blocks:"
    )
    for number, block in enumerate(description.rotor_blocks):
        for problem in _rotor_block(block, names):
            yield f"rotor_blocks.{number}: {problem}"


def _rotor_block(block: RotorBlock, names: list[str]) -> Iterator[str]:
    for name in block.joints:
        if name not in names:
            yield f"unknown joint '{name}'{did_you_mean(name, names)}"
    size = len(block.joints)
    lengths = [len(row) for row in block.matrix]
    if lengths != [size] * size:
        yield f"matrix has rows of lengths {lengths}, expected {size} rows of {size}"
        return
    matrix = np.array(block.matrix)
    if not np.allclose(matrix, matrix.T) or np.linalg.eigvalsh(matrix).min() <= 0.0:
        yield "matrix is not symmetric and positive definite"


def _frames(description: Description, urdf: Urdf) -> Iterator[str]:
    uses = [("base_link", description.base_link)]
    uses += [("root_subtree.default_frame", description.root_subtree.default_frame)]
    uses += [("imus", row.name) for row in description.imus]
    uses += [(f"soles.{name}", name) for name in description.soles]
    uses += [("touchable_links", name) for name in description.touchable_links]
    for kind, frames in description.supports.items():
        uses += [(f"supports.{kind}", name) for name in frames]
    for row in description.ft_sensors:
        uses += [(f"ft_sensors.{row.name}.frame", row.frame or row.name)]
        uses += [(f"ft_sensors.{row.name}.default_frame", row.default_frame)]
    for key, name in uses:
        if name not in urdf.links:
            yield f"{key}: unknown URDF link or frame '{name}'{did_you_mean(name, urdf.links)}"


def _soles(description: Description) -> Iterator[str]:
    known = {frame for frames in description.supports.values() for frame in frames}
    if description.supports.get("none"):
        yield "supports.none must be empty"
    for frame, corners in description.soles.items():
        if frame not in known:
            yield f"soles.{frame} is not the frame of a support{did_you_mean(frame, known)}"
        if len(corners) < 3:
            yield f"soles.{frame}: expected at least 3 corners, got {len(corners)}"


def _sensors(description: Description, urdf: Urdf) -> Iterator[str]:
    joints = [ft_element(row, urdf).joint for row in description.ft_sensors]
    yield from _duplicates(joints, "ft_sensors: joint")
    for row in description.ft_sensors:
        for problem in _sensor(row, urdf):
            yield f"ft_sensors.{row.name}: {problem}"


def _sensor(row: ForceTorqueRow, urdf: Urdf) -> Iterator[str]:
    element = ft_element(row, urdf)
    if row.name not in urdf.ft_elements and row.joint is None:
        hint = did_you_mean(row.name, urdf.ft_elements)
        yield f"the URDF has no force/torque sensor of this name{hint}, and no joint is given"
        return
    if row.joint not in (None, element.joint):
        yield f"joint is '{row.joint}', but '{element.joint}' in the URDF"
    if element.joint not in urdf.joints:
        yield f"unknown joint '{element.joint}'{did_you_mean(element.joint, urdf.joints)}"
    elif urdf.joints[element.joint].type != "fixed":
        yield f"joint '{element.joint}' is {urdf.joints[element.joint].type}, expected fixed"
    if element.frame not in ("parent", "child", "sensor"):
        yield f"<frame> is '{element.frame}', expected parent, child or sensor"
    if element.measure_direction not in ("child_to_parent", "parent_to_child"):
        yield (
            f"<measure_direction> is '{element.measure_direction}', "
            "expected child_to_parent or parent_to_child"
        )


def _places(description: Description, urdf: Urdf) -> Iterator[str]:
    """Frames that exist but lie on the wrong side of a sensor."""
    elements = [ft_element(row, urdf) for row in description.ft_sensors]
    inside = subtree_frames(urdf, [element.joint for element in elements])
    bodies = rigid_bodies(urdf, inside)
    body_of = {frame: body.name for body in bodies.values() for frame in body.placements}
    yield from _inertias(bodies.values())
    root, base = description.root_subtree, description.base_link
    for key, frame in (("base_link", base), ("root_subtree.default_frame", root.default_frame)):
        if frame in urdf.links and frame not in inside[""]:
            yield f"{key}: '{frame}' is distal of a force/torque sensor"
    for row, element in zip(description.ft_sensors, elements, strict=True):
        joint = urdf.joints[element.joint]
        frame = row.frame or row.name
        sides = body_of[joint.parent], body_of[joint.child]
        if frame in urdf.links and body_of[frame] not in sides:
            yield f"ft_sensors.{row.name}.frame: '{frame}' is not fixed to the sensor"
        if row.default_frame in urdf.links and row.default_frame not in inside[element.joint]:
            yield f"ft_sensors.{row.name}.default_frame: '{row.default_frame}' lies elsewhere"


def _inertias(bodies: Iterable[RigidBody]) -> Iterator[str]:
    for body in bodies:
        if body.mass == 0.0:
            continue
        moments = np.linalg.eigvalsh(body.inertia.inertia)
        # Tolerance: files round their moments, and thin plates lie on the boundary.
        if body.mass < 0.0 or moments[0] <= 0.0 or moments[2] > 1.01 * sum(moments[:2]):
            yield f"link '{body.name}': no body has its inertia (principal moments {moments})"
