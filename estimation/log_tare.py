"""Offsets of the force/torque sensors from the beginning of a log."""

from collections.abc import Iterable

from estimation.sensor_log import SensorBlock
from estimation.tare import RestingAverage, StillnessLimits, Tare, TareResult
from estimation.torque_observer import TorqueObserver


def tare_observer(
    observer: TorqueObserver,
    blocks: Iterable[SensorBlock],
    limits: StillnessLimits,
    force_bias: float,
    moment_bias: float,
) -> TareResult:
    """Set the observer's offsets to what a resting robot reveals; see ``Tare``.

    Raises:
        MovingError: The robot moves, or channels are missing.
    """
    average = RestingAverage(observer.robot.joints, limits)
    for block in blocks:
        if block.complete:
            gyro, acc = block.imu_gyro[:, 0], block.imu_acc[:, 0]
            for sample in zip(block.q, block.dq, block.ft, gyro, acc, strict=True):
                average.add(*sample)
    solver = Tare(observer.graph, force_bias, moment_bias)
    result = solver.solve(average.mean(), observer.support, observer.offset)
    observer.offset = result.offset
    return result
