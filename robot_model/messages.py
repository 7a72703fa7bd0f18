"""The messages that travel between the robot's processes.

A message is a frozen dataclass with a versioned ``TYPE``. A field made by
``array`` is a float64 array, by ``flags`` a list of booleans (a boolean array in
Python); every other field is a scalar, a text, or a list or map of them. Shapes
name dimensions: n joints, k force/torque sensors, m inertial sensors; any other
letter is free, and equal letters in one message are equal numbers.
"""

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np


def array(*shape: str | int, unit: str, frame: str = "", optional: bool = False) -> Any:
    """Declare a float64 field with its shape, unit and frame."""
    metadata = {
        "shape": shape,
        "dtype": "float64",
        "unit": unit,
        "frame": frame,
        "optional": optional,
    }
    return field(metadata=metadata, default=None) if optional else field(metadata=metadata)


def flags(*shape: str | int) -> Any:
    """Declare a boolean array field (a list of booleans on the wire)."""
    return field(metadata={"shape": shape, "dtype": "bool", "unit": "", "frame": ""})


def scalar(unit: str = "", frame: str = "", **default: Any) -> Any:
    """Declare a number, text, list or map with the unit of its numbers."""
    return field(metadata={"unit": unit, "frame": frame}, **default)


Vector = np.ndarray


@dataclass(frozen=True, eq=False, kw_only=True)
class RawFrame:
    """What a driver delivers, unfiltered; absent channels are None.

    ``ft_temperature_valid`` is 1 where a temperature is valid, else 0; absent, all are. (Flags
    would travel in every frame, also in those without temperatures.)
    """

    TYPE: ClassVar[str] = "RawFrame/1"
    q: Vector = array("n", unit="rad")
    dq: Vector | None = array("n", unit="rad/s", optional=True)
    ddq: Vector | None = array("n", unit="rad/s^2", optional=True)
    motor_torque: Vector | None = array("n", unit="N m", optional=True)
    ft: Vector = array("k", 6, unit="N, N m", frame="sensor; parent on child")
    imu_gyro: Vector = array("m", 3, unit="rad/s", frame="imu")
    imu_acc: Vector = array("m", 3, unit="m/s^2", frame="imu")
    imu_dgyro: Vector | None = array("m", 3, unit="rad/s^2", frame="imu", optional=True)
    imu_quat_wxyz: Vector | None = array("m", 4, unit="1", frame="world from imu", optional=True)
    joint_valid: Vector = flags("n")
    ft_valid: Vector = flags("k")
    imu_valid: Vector = flags("m")
    ft_temperature: Vector | None = array("k", unit="degC", optional=True)
    ft_temperature_valid: Vector | None = array("k", unit="1, or 0", optional=True)


@dataclass(frozen=True, eq=False, kw_only=True)
class SensorFrame:
    """All channels of one instant, ``stamp - delay``, for the whole robot.

    ``faults``: of sensors that are invalid although they send data, ``name: why``.
    ``ddq_deviation``: standard deviation of ``ddq`` that the steps of the encoders make; absent
    where it is not known.
    """

    TYPE: ClassVar[str] = "SensorFrame/1"
    q: Vector = array("n", unit="rad")
    dq: Vector = array("n", unit="rad/s")
    ddq: Vector = array("n", unit="rad/s^2")
    motor_torque: Vector = array("n", unit="N m")
    ft: Vector = array("k", 6, unit="N, N m", frame="sensor; parent on child")
    imu_gyro: Vector = array("m", 3, unit="rad/s", frame="imu")
    imu_acc: Vector = array("m", 3, unit="m/s^2", frame="imu")
    imu_dgyro: Vector = array("m", 3, unit="rad/s^2", frame="imu")
    imu_quat_wxyz: Vector | None = array("m", 4, unit="1", frame="world from imu", optional=True)
    joint_valid: Vector = flags("n")
    ft_valid: Vector = flags("k")
    imu_valid: Vector = flags("m")
    motor_torque_valid: bool = scalar(default=True)
    delay: float = scalar(unit="s", default=0.0)
    faults: list[str] = scalar(default_factory=list)
    ddq_deviation: Vector | None = array("n", unit="rad/s^2", optional=True)


@dataclass(frozen=True, eq=False, kw_only=True)
class PartState:
    """View of one part of the sensor frame."""

    TYPE: ClassVar[str] = "PartState/1"
    joints: list[str] = scalar()
    q: Vector = array("p", unit="rad")
    dq: Vector = array("p", unit="rad/s")
    ddq: Vector = array("p", unit="rad/s^2")
    motor_torque: Vector = array("p", unit="N m")
    joint_valid: Vector = flags("p")
    motor_torque_valid: bool = scalar(default=True)
    delay: float = scalar(unit="s", default=0.0)


@dataclass(frozen=True, eq=False, kw_only=True)
class PartForceTorque:
    """Force/torque sensors of one part."""

    TYPE: ClassVar[str] = "PartForceTorque/1"
    sensors: list[str] = scalar()
    ft: Vector = array("p", 6, unit="N, N m", frame="sensor; parent on child")
    ft_valid: Vector = flags("p")
    delay: float = scalar(unit="s", default=0.0)


@dataclass(frozen=True, eq=False, kw_only=True)
class Inertial:
    """Inertial sensors of the sensor frame."""

    TYPE: ClassVar[str] = "Inertial/1"
    sensors: list[str] = scalar()
    imu_gyro: Vector = array("m", 3, unit="rad/s", frame="imu")
    imu_acc: Vector = array("m", 3, unit="m/s^2", frame="imu")
    imu_dgyro: Vector = array("m", 3, unit="rad/s^2", frame="imu")
    imu_quat_wxyz: Vector | None = array("m", 4, unit="1", frame="world from imu", optional=True)
    imu_valid: Vector = flags("m")
    delay: float = scalar(unit="s", default=0.0)


@dataclass(frozen=True, eq=False, kw_only=True)
class BaseState:
    """Pose and velocity of the base link."""

    TYPE: ClassVar[str] = "BaseState/1"
    position: Vector = array(3, unit="m", frame="world")
    quat_wxyz: Vector = array(4, unit="1", frame="world from base")
    twist: Vector = array(6, unit="m/s, rad/s", frame="base")
    covariance: Vector = array(12, 12, unit="m, rad, m/s, rad/s (squared)", frame="world, base")


@dataclass(frozen=True, eq=False, kw_only=True)
class JointTorques:
    """Link torques from the force/torque sensors.

    ``reasons``: per joint, why it is invalid; empty while all are valid.
    """

    TYPE: ClassVar[str] = "JointTorques/1"
    torque: Vector = array("n", unit="N m")
    std: Vector = array("n", unit="N m")
    valid: Vector = flags("n")
    reasons: list[str] = scalar(default_factory=list)


@dataclass(frozen=True, eq=False, kw_only=True)
class ExternalWrenches:
    """What the world exerts on the robot, per contact and net per sub-tree.

    Where each sub-tree bears one full wrench the sensors decide them all, and the fields
    from ``unexplained`` to ``decided`` are absent. Else ``unexplained`` is what of each net
    wrench no contact explains, ``rank`` how many combinations of unknowns the sensors decide,
    ``condition`` by how much an error of the net wrench may grow; ``undecided`` has d patterns
    of wrenches of which any multiple may be added without any reading changing, and contacts
    in none are ``decided``.

    ``subtree_reasons``: per sub-tree, why it is invalid; empty while all are valid.
    """

    TYPE: ClassVar[str] = "ExternalWrenches/1"
    frame: list[str] = scalar()
    link: list[str] = scalar()
    subtree: list[str] = scalar()
    point: Vector = array("c", 3, unit="m", frame="link")
    wrench: Vector = array("c", 6, unit="N, N m", frame="frame, about the contact point")
    covariance: Vector = array("c", 6, 6, unit="N, N m (squared)", frame="as wrench")
    valid: Vector = flags("c")
    kind: list[str] = scalar()
    subtree_wrench: Vector = array("s", 6, unit="N, N m", frame="default frame of the sub-tree")
    subtree_valid: Vector = flags("s")
    subtree_covariance: Vector | None = array(
        "s", 6, 6, unit="N, N m (squared)", frame="as subtree_wrench", optional=True
    )
    unexplained: Vector | None = array(
        "s", 6, unit="N, N m", frame="default frame of the sub-tree", optional=True
    )
    rank: Vector | None = array("s", unit="1", optional=True)
    condition: Vector | None = array("s", unit="1", optional=True)
    undecided: Vector | None = array(
        "d",
        "c",
        6,
        unit="N, N m",
        frame="as wrench; adding any of it changes no reading",
        optional=True,
    )
    decided: list[bool] = scalar(default_factory=list)
    subtree_reasons: list[str] = scalar(default_factory=list)


@dataclass(frozen=True, eq=False, kw_only=True)
class FtPrediction:
    """Force/torque readings that the model predicts without contacts, and the measured ones.

    ``covariance`` is that of predicted - measured while nothing touches. ``reasons``: per
    sensor, why it is invalid; empty while all are valid.
    """

    TYPE: ClassVar[str] = "FtPrediction/1"
    predicted: Vector = array("k", 6, unit="N, N m", frame="sensor; parent on child")
    measured: Vector = array("k", 6, unit="N, N m", frame="sensor; parent on child")
    valid: Vector = flags("k")
    covariance: Vector | None = array(
        "k", 6, 6, unit="N, N m (squared)", frame="as predicted", optional=True
    )
    reasons: list[str] = scalar(default_factory=list)


@dataclass(frozen=True, eq=False, kw_only=True)
class GravityTorques:
    """Joint torques that hold the robot against gravity."""

    TYPE: ClassVar[str] = "GravityTorques/1"
    torque: Vector = array("n", unit="N m")


@dataclass(frozen=True, eq=False, kw_only=True)
class Residuals:
    """Momentum residuals and the thresholds they are compared with."""

    TYPE: ClassVar[str] = "Residuals/1"
    internal: Vector = array("n", unit="N m")
    external: Vector = array(6, unit="N, N m", frame="base")
    classical: Vector | None = array("n", unit="N m", optional=True)
    threshold_internal: Vector = array("n", unit="N m")
    threshold_external: Vector = array(6, unit="N, N m", frame="base")
    valid_internal: bool = scalar(default=True)
    valid_external: bool = scalar(default=True)
    valid_classical: bool = scalar(default=False)


@dataclass(frozen=True, eq=False, kw_only=True)
class Contacts:
    """Where the robot is touched.

    ``flags``: maps ``limb, state (none, contact, collision), probability, onset``
    (onset in ns of the session's clock, 0 without contact; also ``force`` [N], ``valid``
    with a ``reason`` when it is not, and ``statistic`` and ``threshold`` in standard
    deviations). ``body``: the same for the whole body, empty while it is not judged.
    ``hypotheses``: maps ``links, point (3) [m], force (3) [N], covariance (6x6; of
    [point, force], m and N), probability``, best first, in the frame of the first link.
    ``none_probability``: that no touch explains the data, 1 without a touch.
    """

    TYPE: ClassVar[str] = "Contacts/1"
    flags: list[dict[str, Any]] = scalar()
    hypotheses: list[dict[str, Any]] = scalar()
    none_probability: float = scalar(unit="1", default=1.0)
    body: dict[str, Any] = scalar(default_factory=dict)


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactMap:
    """How probable a touch is at each place of the surface, and its line of action.

    The points of ``link[i]`` are the next ``count[i]`` rows; links that are hopeless are
    left out, and without a touch all is empty. Each touched ``limb`` has the line along
    which its force acts on the robot.
    """

    TYPE: ClassVar[str] = "ContactMap/1"
    link: list[str] = scalar()
    count: list[int] = scalar()
    point: Vector = array("p", 3, unit="m", frame="link")
    probability: Vector = array("p", unit="1")
    limb: list[str] = scalar()
    line_point: Vector = array("c", 3, unit="m", frame="base")
    line_direction: Vector = array("c", 3, unit="1", frame="base")


@dataclass(frozen=True, eq=False, kw_only=True)
class ContactPoints:
    """Where unknown wrenches act now; replaces the default contact of each sub-tree named.

    ``unknown`` says what of each wrench is: wrench (all are, when it is empty), force (no
    moment about the point), direction (a force along ``vector``), known (``vector`` is the
    wrench) or none (nothing touches that sub-tree). ``vector`` is zero where it is not needed.
    """

    TYPE: ClassVar[str] = "ContactPoints/1"
    link: list[str] = scalar()
    point: Vector = array("c", 3, unit="m", frame="link")
    unknown: list[str] = scalar(default_factory=list)
    vector: Vector | None = array("c", 6, unit="1, or N and N m", frame="link", optional=True)


@dataclass(frozen=True, eq=False, kw_only=True)
class JointCommand:
    """A command to the boards: ``mode`` is position, velocity or torque."""

    TYPE: ClassVar[str] = "JointCommand/1"
    mode: str = scalar()
    value: Vector = array("n", unit="rad, rad/s or N m")


@dataclass(frozen=True, eq=False, kw_only=True)
class MotorCommand:
    """What the sensor server sends to the boards: position mode with a feed-forward torque."""

    TYPE: ClassVar[str] = "MotorCommand/1"
    mode: str = scalar()
    value: Vector = array("n", unit="rad, rad/s or N m")
    feedforward: Vector = array("n", unit="N m")


@dataclass(frozen=True, eq=False, kw_only=True)
class GroundTruth:
    """What the plant knows; shown and compared, never used by an estimator.

    ``pushes``: maps ``id, link, point (3) [m, link frame], force_world (3) [N]``.
    """

    TYPE: ClassVar[str] = "GroundTruth/1"
    q: Vector = array("n", unit="rad")
    dq: Vector = array("n", unit="rad/s")
    ddq: Vector = array("n", unit="rad/s^2")
    link_torque: Vector = array("n", unit="N m")
    motor_torque: Vector = array("n", unit="N m")
    ft: Vector = array("k", 6, unit="N, N m", frame="sensor; parent on child")
    base_position: Vector = array(3, unit="m", frame="world")
    base_quat_wxyz: Vector = array(4, unit="1", frame="world from base")
    base_twist: Vector = array(6, unit="m/s, rad/s", frame="base")
    base_acceleration: Vector = array(6, unit="m/s^2, rad/s^2", frame="base; spatial")
    pushes: list[dict[str, Any]] = scalar()
    support_frames: list[str] = scalar()
    support_wrench: Vector = array("s", 6, unit="N, N m", frame="support frame")
    fallen: bool = scalar(default=False)
