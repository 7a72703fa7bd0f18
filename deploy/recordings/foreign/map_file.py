"""The map from another program's log to a robot's channels."""

from collections.abc import Iterator
from pathlib import Path
from typing import Literal

import yaml
from pydantic import BaseModel, ConfigDict, Field, PositiveFloat, ValidationError, model_validator

from bus.names import did_you_mean
from deploy.errors import UsageError
from robot_model import Robot


class Strict(BaseModel):
    """A part of the file; unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True)


class Joints(Strict):
    """Numbers of joints in the order of the log; null where a number is left out."""

    joints: list[str | None] = Field(min_length=1)
    unit: Literal["rad", "deg", "N m"] = "rad"  # per second (squared) for rates


class Convention(Strict):
    """A force/torque convention in the URDF's words (docs/conventions.md)."""

    measure_direction: Literal["parent_to_child", "child_to_parent"]
    frame: Literal["parent", "child", "sensor"]


class ForceTorque(Strict):
    """Six numbers, force before moment, of one sensor.

    ``wrenchbus``: parent on child, in the frame that bears the sensor's name; ``urdf``: as
    the sensor's element of the URDF says; or a convention of its own.
    """

    sensor: str
    convention: Literal["wrenchbus", "urdf"] | Convention


class Imu(Strict):
    """Proper acceleration [m/s^2] and angular velocity of one inertial sensor."""

    name: str
    gyro_unit: Literal["rad/s", "deg/s"]
    acc_at: int = Field(default=3, ge=0)  # iCub's inertial: 3 angles, acc, gyro, 3 of the compass
    gyro_at: int = Field(default=6, ge=0)


class Stream(Strict):
    """One stream of numbers of a log, and what of the robot it is; exactly one of the last six."""

    source: str = ""  # folder below DIR, or the port that its info.log names
    columns: list[str] = []  # of a table
    inside: list[int] = []  # positions of nested lists that lead to the numbers
    q: Joints | None = None
    dq: Joints | None = None
    ddq: Joints | None = None
    motor_torque: Joints | None = None
    ft: ForceTorque | None = None
    imu: Imu | None = None

    @model_validator(mode="after")
    def _one_target(self) -> "Stream":
        given = [name for name in TARGETS if getattr(self, name) is not None]
        if len(given) != 1:
            raise ValueError(f"expected one of {', '.join(TARGETS)}, got {given or 'none'}")
        return self

    @property
    def target(self) -> str:
        """The one that is given: q, dq, ddq, motor_torque, ft or imu."""
        return next(name for name in TARGETS if getattr(self, name) is not None)

    @property
    def width(self) -> int:
        """Numbers that a message must have."""
        if self.imu is not None:
            return max(self.imu.acc_at, self.imu.gyro_at) + 3
        return 6 if self.ft is not None else len(getattr(self, self.target).joints)


TARGETS = ("q", "dq", "ddq", "motor_torque", "ft", "imu")


class TimeColumn(Strict):
    """The column of a table that holds the time."""

    column: str
    unit: Literal["s", "ms", "us", "ns"] = "s"


class LogMap(Strict):
    """A map file."""

    robot: str = "icub"
    grid: Literal["fastest"] | PositiveFloat = "fastest"  # as the fastest stream, or a rate [Hz]
    gap: float = Field(default=5.0, gt=1.0)  # periods of a stream that are bridged
    stamps: Literal["sent", "received"] = "sent"  # which, where a log has both
    time: TimeColumn | None = None  # tables only
    streams: list[Stream] = Field(min_length=1)
    held: dict[str, float] = {}  # rad; joints that the log lacks and that stood still


def read_map(path: Path) -> LogMap:
    """Read a map file; raise UsageError with the key, what was expected and what it has."""
    try:
        return LogMap.model_validate(yaml.safe_load(path.read_text()))
    except (OSError, UnicodeDecodeError, yaml.YAMLError) as error:
        raise UsageError(f"{path}: {error}") from None
    except ValidationError as error:
        first = error.errors()[0]
        key = ".".join(map(str, first["loc"])) or "the file"
        raise UsageError(f"{path}: {key}: {first['msg']}, got {first['input']!r:.60}") from None


def check_names(log_map: LogMap, robot: Robot, path: Path) -> None:
    """Raise UsageError when the map names what the robot has not, or a channel twice."""
    seen: set[tuple[str, str]] = set()
    for target, name in _channels(log_map):
        known, what = _known(target, robot)
        if name not in known:
            hint = did_you_mean(name, known) or f" (it has {', '.join(known)})"
            raise UsageError(f"{path}: {robot.name} has no {what} {name}{hint}")
        if (target, name) in seen:
            raise UsageError(f"{path}: {target} of {name} is given twice")
        seen.add((target, name))


def _channels(log_map: LogMap) -> Iterator[tuple[str, str]]:
    yield from (("q", name) for name in log_map.held)
    for stream in log_map.streams:
        if stream.ft is not None:
            yield "ft", stream.ft.sensor
        elif stream.imu is not None:
            yield "imu", stream.imu.name
        else:
            joints = getattr(stream, stream.target).joints
            yield from ((stream.target, name) for name in joints if name is not None)


def _known(target: str, robot: Robot) -> tuple[tuple[str, ...], str]:
    if target == "ft":
        return robot.ft_sensors, "force/torque sensor"
    return (robot.imus, "inertial sensor") if target == "imu" else (robot.joints, "joint")
