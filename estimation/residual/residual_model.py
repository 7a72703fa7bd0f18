"""The model that momentum residuals run on: cut at the sensors that measure the supports."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin

from robot_model import Robot
from robot_model.tree import TreeModel, build_tree

Array = np.ndarray


@dataclass(frozen=True, eq=False)
class ResidualModel:
    """A floating-base model without what lies beyond the supports' force/torque sensors.

    What those sensors read is then the known wrench of the support (R eq. 10), and the
    weight and motion of the feet need no correction.
    """

    model: pin.Model  # free-flyer at the base link, nv = 6 + n, gravity as in the URDF
    joint_q: Array  # (n,) index of each joint of the description in q
    joint_v: Array  # (n,)
    sensors: tuple[int, ...]  # indices of those that carry supports
    sensor_frames: tuple[int, ...]  # their frames in the model
    imu_frame: int


def support_sensors(robot: Robot, support: str) -> list[int]:
    """Return the sensors that measure the supports; ValueError for an unmeasured support."""
    subtrees = [robot.subtrees[robot.subtree_of(frame)] for frame in robot.supports[support]]
    unmeasured = [tree.name for tree in subtrees if tree.ft_in < 0 or tree.ft_out]
    if unmeasured:
        raise ValueError(
            f"support '{support}' rests on {', '.join(unmeasured)}, whose wrench no "
            f"force/torque sensor measures; residuals of a floating base need it"
        )
    return [tree.ft_in for tree in subtrees]


def is_measured(robot: Robot, support: str) -> bool:
    """Whether every support frame hangs on a force/torque sensor of its own."""
    try:
        sensors = support_sensors(robot, support)
    except ValueError:
        return False
    return len(set(sensors)) == len(sensors)


def residual_model(robot: Robot, support: str) -> ResidualModel:
    """Build the model for a kind of support; a support that is not measured cuts nothing."""
    tree = build_tree(robot, robot.base_link)
    model = tree.model
    sensors = support_sensors(robot, support) if is_measured(robot, support) else []
    places = _drop_beyond(model, build_tree(robot, robot.base_link, cut=True), sensors)
    frames = tuple(
        model.addFrame(pin.Frame(f"support_{i}", joint, 0, place, pin.FrameType.OP_FRAME))
        for i, (joint, place) in zip(sensors, places, strict=True)
    )
    return ResidualModel(
        model=model,
        joint_q=tree.joint_q,
        joint_v=tree.joint_v,
        sensors=tuple(sensors),
        sensor_frames=frames,
        imu_frame=tree.frame_id(robot.imus[0]),
    )


def rows_above(model: pin.Model, joint: int) -> Array:
    """Return (nv,) bool: the rows of all joints from the root to ``joint``, included."""
    rows = np.zeros(model.nv, dtype=bool)
    while joint > 0:
        start = model.joints[joint].idx_v
        rows[start : start + model.joints[joint].nv] = True
        joint = model.parents[joint]
    return rows


def joint_at(model: pin.Model, start: int) -> int:
    """Return the joint whose velocities start at an index of v."""
    return next(i for i in range(1, model.njoints) if model.joints[i].idx_v == start)


def _drop_beyond(model: pin.Model, cut: TreeModel, sensors: list[int]) -> list[tuple[int, pin.SE3]]:
    """Take the bodies beyond some sensors out of a model, with the help of its cut twin.

    Returns the joint of the model that bears each of those sensors, and the sensor's
    placement in it.
    """
    cuts = [joint_at(cut.model, start) for start in cut.cut_v[:, 0]]
    dropped = {cuts[i] for i in sensors}
    twin = {i: model.getJointId(cut.model.names[i]) for i in range(1, cut.model.njoints)}
    inertias = {i: pin.Inertia.Zero() for i in range(1, model.njoints)}
    for joint in range(1, cut.model.njoints):
        if dropped.isdisjoint(cut.model.supports[joint]):
            bearer, place = _bearer(cut.model, cuts, joint)
            inertias[twin[bearer]] += place.act(cut.model.inertias[joint])
    for joint, inertia in inertias.items():
        model.inertias[joint] = inertia
    bearers = [_bearer(cut.model, cuts, cuts[i]) for i in sensors]
    return [(twin[joint], place) for joint, place in bearers]


def _bearer(model: pin.Model, cuts: list[int], joint: int) -> tuple[int, pin.SE3]:
    """Return the first joint at or above ``joint`` that is no cut, and the placement in it."""
    place = pin.SE3.Identity()
    while joint in cuts:
        place = model.jointPlacements[joint] * place
        joint = model.parents[joint]
    return joint, place
