"""The bus's codec on a sensor frame, hot, beside plain MessagePack with arrays as lists."""

from collections.abc import Callable
from time import perf_counter_ns
from typing import Any

import msgpack
import numpy as np

from bus.decoder import Decoder
from bus.encoder import Encoder
from bus.envelope import new_source
from robot_model import load_robot
from robot_model.messages import SensorFrame

ROUNDS, BURST = 200, 100
Step = Callable[[int], Any]


def run(quick: bool = False) -> list[dict[str, Any]]:
    """Return the median cost of encoding and decoding in microseconds."""
    robot = load_robot("icub")
    frame = _frame(**robot.dimensions)
    sizes = {"model": robot.model_hash, "dimensions": robot.dimensions}
    encoder = Encoder(SensorFrame, new_source(), **sizes)
    decoder = Decoder(SensorFrame, **sizes)
    messages = [encoder.encode(frame, i, 10**6 * i, 1, i, i) for i in range(BURST)]
    plain = {name: np.asarray(value) for name, value in vars(frame).items() if value is not None}
    listed = _pack(plain)
    rounds = ROUNDS // 10 if quick else ROUNDS
    pairs: dict[str, tuple[Step, Step]] = {
        "encode a sensor frame": (
            lambda i: encoder.encode(frame, i, 10**6 * i, 1, i, i),
            lambda i: _pack(plain),
        ),
        "decode a sensor frame": (lambda i: decoder.decode(messages[i]), lambda i: _unpack(listed)),
    }
    return [_row(name, *pair, rounds) for name, pair in pairs.items()]


def _row(name: str, ours: Step, theirs: Step, rounds: int) -> dict[str, Any]:
    times: tuple[list[float], list[float]] = ([], [])
    for _ in range(rounds):  # interleaved, so that both meet the same machine
        for function, kept in zip((ours, theirs), times, strict=True):
            kept.append(_burst(function))
    value, peer = (float(np.median(kept)) for kept in times)
    return {"name": name, "value": value, "unit": "us", "peer": peer, "ratio": value / peer}


def _burst(function: Step) -> float:
    start = perf_counter_ns()
    for number in range(BURST):
        function(number)
    return 1e-3 * (perf_counter_ns() - start) / BURST


def _pack(arrays: dict[str, np.ndarray]) -> Any:
    return msgpack.packb({name: array.tolist() for name, array in arrays.items()})


def _unpack(data: bytes) -> dict[str, np.ndarray]:
    return {name: np.array(values) for name, values in msgpack.unpackb(data).items()}


def _frame(n: int, k: int, m: int) -> SensorFrame:
    joint, inertial = np.linspace(-1.0, 1.0, n), np.ones((m, 3))
    return SensorFrame(
        q=joint,
        dq=joint,
        ddq=joint,
        motor_torque=joint,
        ft=np.ones((k, 6)),
        imu_gyro=inertial,
        imu_acc=inertial,
        imu_dgyro=inertial,
        joint_valid=np.ones(n, bool),
        ft_valid=np.ones(k, bool),
        imu_valid=np.ones(m, bool),
    )
