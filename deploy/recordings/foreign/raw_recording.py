"""Aligned streams as a recording of raw frames, which the replay driver plays."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from bus.encoder import Encoder
from bus.envelope import WALL, envelope_of, new_source
from bus.recording import RecordingWriter
from bus.schema import fields_of
from deploy.recordings.foreign.alignment import common_grid, interpolate
from deploy.recordings.foreign.problems import Problems
from deploy.recordings.foreign.tracks import Track
from deploy.recordings.robots import attach_robot
from robot_model import Robot, ports
from robot_model.messages import RawFrame

Array = np.ndarray
FLAGS = {"q": "joint_valid", "dq": "joint_valid", "ddq": "joint_valid", "ft": "ft_valid"}
FLAGS |= dict.fromkeys(("imu_gyro", "imu_acc", "imu_dgyro"), "imu_valid")
SHAPES = {"ft": ("k", 6), "imu_gyro": ("m", 3), "imu_acc": ("m", 3), "imu_dgyro": ("m", 3)}
OPTIONAL = ("dq", "ddq", "imu_dgyro")


@dataclass(frozen=True, eq=False)
class Aligned:
    """All channels at common instants."""

    stamps: Array  # (G,) ns
    values: Mapping[str, Array]  # by field of RawFrame, (G, n), (G, k, 6), (G, m, 3)
    valid: Mapping[str, Array]  # the same fields, (G, n), (G, k) or (G, m)

    @property
    def rate(self) -> float:
        """Median rate [Hz]; 0 with fewer than two instants."""
        steps = np.diff(self.stamps)
        return 1e9 / float(np.median(steps)) if len(steps) else 0.0


def align(
    tracks: Sequence[Track],
    robot: Robot,
    grid: str | float,
    gap: float,
    held: Mapping[str, float],
    problems: Problems,
) -> Aligned:
    """Bring all streams to common instants.

    Args:
        tracks: The streams.
        robot: Whose they are.
        grid: See `common_grid`.
        gap: See `interpolate`.
        held: Positions of joints that stood still [rad].
        problems: Gets a warning for each channel that the log lacks.
    """
    stamps = common_grid(tracks, grid)
    values, valid = {}, {}
    for kind in dict.fromkeys(("q", "ft", "imu_gyro", "imu_acc", *(t.kind for t in tracks))):
        symbol, *rest = SHAPES.get(kind, ("n",))
        count = robot.dimensions[str(symbol)]
        values[kind] = np.zeros((len(stamps), count, *rest))
        valid[kind] = np.zeros((len(stamps), count), dtype=bool)
        for track in tracks:
            if track.kind == kind:
                found, good = interpolate(track, stamps, gap)
                values[kind][:, track.rows] = found
                valid[kind][:, track.rows] = good[:, None]
    for name, position in held.items():
        _hold(values, valid, robot.joints.index(name), position)
    _say_what_lacks(valid, robot, problems)
    return Aligned(stamps, values, valid)


def _hold(values: dict[str, Array], valid: dict[str, Array], row: int, position: float) -> None:
    values["q"][:, row] = position
    for kind in ("q", "dq", "ddq", "motor_torque"):
        if kind in valid:
            valid[kind][:, row] = True


def _say_what_lacks(valid: dict[str, Array], robot: Robot, problems: Problems) -> None:
    """Warn of channels that are never valid; drop fields that only some channels have."""
    names = {"q": robot.joints, "ft": robot.ft_sensors, "imu_acc": robot.imus}
    for kind, known in names.items():
        if missing := [known[i] for i in np.flatnonzero(~valid[kind].any(axis=0))]:
            problems.warn(f"{kind}: never valid: {', '.join(missing)}")
    for kind in ("dq", "ddq", "motor_torque"):
        base = "q" if kind in FLAGS else kind
        if kind in valid and not (valid[kind].any(axis=0) >= valid[base].any(axis=0)).all():
            problems.warn(f"{kind}: not for all joints that have a position; left out")
            del valid[kind]


def frames(aligned: Aligned, robot: Robot) -> Any:
    """Yield one raw frame per instant."""
    fields = [kind for kind in FLAGS if kind in aligned.valid]
    flags = {name: _all_valid(aligned, name) for name in sorted(set(FLAGS.values()))}
    for kind in fields:
        mask = flags[FLAGS[kind]]
        aligned.values[kind][~mask] = 0.0
    torque = aligned.valid.get("motor_torque")
    for index in range(len(aligned.stamps)):
        content = {kind: aligned.values[kind][index] for kind in fields}
        content |= {name: mask[index] for name, mask in flags.items()}
        if torque is not None and torque[index].all():
            content["motor_torque"] = aligned.values["motor_torque"][index]
        yield RawFrame(**content)


def _all_valid(aligned: Aligned, flag: str) -> Array:
    kinds = [kind for kind, name in FLAGS.items() if name == flag and kind in aligned.valid]
    return np.logical_and.reduce([aligned.valid[kind] for kind in kinds])


def write_raw(aligned: Aligned, robot: Robot, about: Mapping[str, str], out: Path) -> None:
    """Write a recording of ``/<robot>/raw:o``, with the robot's description beside it.

    Stamps are the log's times, wall clock; ``acquired``, ``sent`` and the arrival are equal to
    them. Raises OSError when the file cannot be written.
    """
    name = ports.name("raw", robot)
    source = new_source()
    encoder = Encoder(RawFrame, source, 0, robot.model_hash, robot.dimensions)
    writer = RecordingWriter(out, about)
    try:
        attach_robot(writer, robot)
        channel = writer.open_channel(name, _information(aligned.rate))
        stamps = aligned.stamps.tolist()
        for number, (stamp, frame) in enumerate(
            zip(stamps, frames(aligned, robot), strict=True), start=1
        ):
            data = encoder.encode(frame, number, stamp, WALL, stamp, stamp)
            writer.write(channel, data, envelope_of(data), stamp)
    finally:
        writer.close()


def _information(rate: float) -> dict[str, Any]:
    return {
        "type": RawFrame.TYPE,
        "fields": [field.describe() for field in fields_of(RawFrame)],
        "nominal_hz": round(rate, 3),
        "direction": "output",
        "owner": {"service": "import"},
    }
