"""Offsets of the force/torque sensors from the beginning of a log."""

from collections.abc import Iterable

from estimation.offline.sensor_log import SensorBlock
from estimation.resting import RestingAverage, StillnessLimits
from estimation.tare import OffsetLimits, Tare, TareResult
from estimation.torque_observer import TorqueObserver


def tare_observer(
    observer: TorqueObserver,
    blocks: Iterable[SensorBlock],
    limits: StillnessLimits,
    largest: OffsetLimits,
    force_bias: float,
    moment_bias: float,
) -> TareResult:
    """Set the observer's offsets to what a resting robot reveals; see ``Tare``.

    Raises:
        TareError: The robot moves, channels are missing, or an offset is too large for one.
    """
    robot = observer.robot
    average = RestingAverage(robot.joints, limits, robot.ft_sensors)
    for block in blocks:
        if block.complete:
            gyro, acc = block.imu_gyro[:, 0], block.imu_acc[:, 0]
            for sample in zip(block.q, block.dq, block.ft, gyro, acc, strict=True):
                average.add(*sample)
    solver = Tare(observer.graph, force_bias, moment_bias)
    result = solver.solve(average.mean(), observer.support, observer.offset)
    result.check(robot.ft_sensors, largest)
    observer.offset = result.offset
    return result
