"""A recording's raw frames as a log; its sensor frames where no raw ones were recorded."""

from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from bus.decoder import Decoder
from bus.errors import WireError
from bus.recording import Recording
from deploy.errors import CommandError
from deploy.estimate.given import Given
from deploy.recordings.npz_arrays import check_rising
from estimation.offline.sensor_log import SensorLog
from robot_model import Robot, ports
from robot_model.messages import RawFrame, SensorFrame
from robot_model.names import did_you_mean

NEEDED = ("q", "ft", "imu_gyro", "imu_acc", "joint_valid", "ft_valid", "imu_valid")
OPTIONAL = ("dq", "ddq", "motor_torque", "imu_dgyro", "imu_quat_wxyz")
SOURCES = {"raw": RawFrame, "sensors": SensorFrame}


class _Frames(NamedTuple):
    stamps: list[int]  # ns, of the instants that the values describe
    frames: list[Any]
    left_out: int


def read_recording(file: Path, robot: Robot) -> Given:
    """Return the log in a recording.

    Raises:
        CommandError: It has no frames of this robot, or their stamps jump back.
        RecordingError: It is no recording, or a spoilt one.
    """
    tape = Recording(file)
    key = _source(tape, robot)
    stamps, frames, left_out = _frames(tape, key, robot)
    port, warnings = ports.name(key, robot), []
    if left_out:
        warnings.append(f"{port}: {left_out} frames are invalid, and left out")
    values = {name: np.array([getattr(frame, name) for frame in frames]) for name in NEEDED}
    for name in OPTIONAL:
        found = [_given(frame, name) for frame in frames]
        if all(each is not None for each in found):
            values[name] = np.array(found)
        elif any(each is not None for each in found):
            warnings.append(f"{port}: {name} is not in every frame, and not used")
    check_rising(np.array(stamps), file)
    log = SensorLog(stamp=np.array(stamps), **values)
    return Given(log, robot, warnings)


def _source(tape: Recording, robot: Robot) -> str:
    for key in SOURCES:
        port = tape.ports.get(ports.name(key, robot))
        if port is not None and port.count:
            return key
    wanted = " nor ".join(ports.name(key, robot) for key in SOURCES)
    hint = did_you_mean(ports.name("raw", robot), [p.name for p in tape.ports.values() if p.count])
    raise CommandError(f"{tape.path}: neither {wanted} was recorded{hint}")


def _frames(tape: Recording, key: str, robot: Robot) -> _Frames:
    """Decode the valid frames."""
    decoder = Decoder(SOURCES[key], robot.model_hash, robot.dimensions)
    stamps, frames, left_out, refused = [], [], 0, ""
    for message in tape.messages([ports.name(key, robot)]):
        try:
            frame, envelope = decoder.decode(message.data)
        except WireError as error:
            left_out, refused = left_out + 1, str(error)
            continue
        if not envelope.valid:
            left_out += 1
            continue
        stamps.append(envelope.stamp - round(getattr(frame, "delay", 0.0) * 1e9))
        frames.append(frame)
    if not frames:
        why = f": {refused}" if refused else ""
        raise CommandError(f"{tape.path}: no valid frame of {robot.name}{why}")
    return _Frames(stamps, frames, left_out)


def _given(frame: Any, name: str) -> Any:
    if name == "motor_torque" and not getattr(frame, "motor_torque_valid", True):
        return None
    return getattr(frame, name)
