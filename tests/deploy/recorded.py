"""A small recording of a robot, made without a bus."""

from dataclasses import dataclass
from pathlib import Path
from typing import Any, ClassVar

import numpy as np

from bus.encoder import Encoder
from bus.envelope import SIMULATED, envelope_of, new_source
from bus.recording import RecordingWriter
from bus.schema import fields_of
from deploy.recordings.robots import attach_robot
from robot_model import Robot, ports
from robot_model.messages import BaseState, Contacts, ExternalWrenches, JointTorques, SensorFrame

START = 1_700_000_000_000_000_000  # ns
TICK = 1_000_000  # ns
FRAMES = 100
LATENCY = 3_000_000  # ns from measurement to sending
BUNDLE = 20_000_000  # ns; the recorder sees everything in bundles


@dataclass(frozen=True, eq=False, kw_only=True)
class Note:
    """A message of a user's own."""

    TYPE: ClassVar[str] = "Note/1"
    text: str
    count: int


def make_recording(path: Path, robot: Robot) -> Path:
    """Record 100 ms: each port's messages, in order of measurement, arriving in bundles."""
    writer = RecordingWriter(path, {"version": "test", "machine": "a test"})
    attach_robot(writer, robot)
    writers = [
        _Port(writer, ports.name(key, robot), kind, robot)
        for key, kind in (
            ("sensors", SensorFrame),
            ("base", BaseState),
            ("torques", JointTorques),
            ("wrenches", ExternalWrenches),
            ("contacts", Contacts),
        )
    ]
    note = _Port(writer, "/user/note:o", Note, robot)
    for tick in range(FRAMES):
        messages = sensors(robot, tick), base(tick), torques(robot), wrenches(tick), contacts()
        for port, message in zip(writers, messages, strict=True):
            port.write(tick, message)
        if tick == 50:
            note.write(tick, Note(text="half", count=50))
    writer.close()
    return path


class _Port:
    def __init__(self, writer: RecordingWriter, name: str, kind: Any, robot: Robot):
        info = {"type": kind.TYPE, "direction": "output", "nominal_hz": 1000.0}
        info["fields"] = [field.describe() for field in fields_of(kind)]
        self._writer, self._channel = writer, writer.open_channel(name, info)
        self._encoder = Encoder(kind, new_source(), 0, robot.model_hash, robot.dimensions)
        self._seq = 0

    def write(self, tick: int, message: Any) -> None:
        self._seq += 1
        acquired = START + tick * TICK
        times = (tick * TICK, SIMULATED, acquired, acquired + LATENCY)
        data = self._encoder.encode(message, self._seq, *times)
        arrival = (acquired // BUNDLE + 1) * BUNDLE + LATENCY
        self._writer.write(self._channel, data, envelope_of(data), arrival)


def sensors(robot: Robot, tick: int) -> SensorFrame:
    """Return a frame in which each joint's position tells its number, and the first moves."""
    n, k, m = (robot.dimensions[letter] for letter in "nkm")
    q = 0.01 * np.arange(n)
    q[0] = 0.1 * np.sin(0.1 * tick)
    return SensorFrame(
        q=q,
        dq=np.zeros(n),
        ddq=np.zeros(n),
        motor_torque=np.zeros(n),
        ft=np.minimum(np.arange(6.0 * k), 24.0).reshape(k, 6),  # within the ranges
        imu_gyro=np.zeros((m, 3)),
        imu_acc=np.full((m, 3), 9.81),
        imu_dgyro=np.zeros((m, 3)),
        joint_valid=np.ones(n, dtype=bool),
        ft_valid=np.ones(k, dtype=bool),
        imu_valid=np.ones(m, dtype=bool),
        delay=0.024,
    )


def base(tick: int) -> BaseState:
    """Return a base that stands 0.6 m high."""
    return BaseState(
        position=np.array([0.0, 0.0, 0.6]),
        quat_wxyz=np.array([1.0, 0.0, 0.0, 0.0]),
        twist=np.zeros(6),
        covariance=np.diag(np.arange(1.0, 13.0)),
    )


def torques(robot: Robot) -> JointTorques:
    """Return torques that tell their joint's number."""
    n = robot.n
    return JointTorques(torque=np.arange(float(n)), std=np.ones(n), valid=np.ones(n, dtype=bool))


def wrenches(tick: int) -> ExternalWrenches:
    """Return one contact at first, and two from the middle on."""
    frames = ["l_sole", "l_hand_dh_frame"][: 1 + tick // 50]
    count = len(frames)
    return ExternalWrenches(
        frame=frames,
        link=["l_foot", "l_hand"][:count],
        subtree=["l_foot", "l_arm"][:count],
        point=np.zeros((count, 3)),
        wrench=np.array([[0.0, 0.0, 100.0, 0.0, 0.0, 0.0], [0.0, 10.0, 0.0, 0.0, 0.0, 0.0]])[
            :count
        ],
        covariance=np.stack([np.eye(6)] * count),
        valid=np.ones(count, dtype=bool),
        kind=["support", "touch"][:count],
        subtree_wrench=np.zeros((7, 6)),
        subtree_valid=np.ones(7, dtype=bool),
    )


def contacts() -> Contacts:
    """Return a touch of the left hand."""
    flag = {"limb": "l_arm", "state": "contact", "probability": 0.9, "onset": 5, "force": 10.0}
    hypothesis = {
        "links": ["l_hand"],
        "point": [0.0, 0.0, 0.01],
        "force": [0.0, 10.0, 0.0],
        "covariance": np.eye(6).tolist(),
        "probability": 0.8,
    }
    return Contacts(flags=[flag], hypotheses=[hypothesis], none_probability=0.1)
