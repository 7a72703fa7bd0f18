"""`wrenchbus estimate` over a log of the simulated robot, per sample of one core

1 kHz, `realistic` sensors, positions only; 100 us are ten times real time. The robot stands
untouched but for one push in half of the log. iDynTree's step, from NumPy to NumPy on the
samples of the log and in turns with it, tells how fast the machine is: on the one for which
the 100 us were asked it takes 37 us.
"""

from collections.abc import Callable
from dataclasses import replace
from time import process_time

import numpy as np

from benchmarks.idyntree_observer import IdyntreeObserver
from benchmarks.rows import Row, row
from deploy.estimate.given import Given
from deploy.estimate.run import Estimation
from estimation.offline.log_filter import LogFilter
from estimation.offline.sensor_log import SensorLog
from robot_model import Robot, load_robot
from robot_sim import Plant

SETTLING, SIZE, ROUNDS = 4000, 4000, 9
TARE = 1.0  # s
LIMIT, RATIO = 100.0, 2.7  # us; times iDynTree's step
PUSH = ("l_forearm", np.array([0.05, -0.01, -0.034]), np.array([-4.0, 1.2, 11.0]))


def run(quick: bool = False) -> list[Row]:
    """Return the fastest of some runs, with and without residuals and contacts."""
    robot = load_robot("icub")
    log = _log(robot, 1500 if quick else SIZE)
    steps = (
        _estimate(Given(replace(log, motor_torque=None), robot)),
        _estimate(Given(log, robot)),
        _peer(robot, log),
    )
    # in turns, so that all see the same machine
    rounds = [[step() for step in steps] for _ in range(2 if quick else ROUNDS)]
    observed, everything, peer = np.min(rounds, axis=0).tolist()
    return [
        row("torques and wrenches, with standard deviations", observed, "us", peer, limit=LIMIT),
        row("residuals and contacts too", everything, "us", peer, limit=LIMIT),
        row(
            "residuals and contacts too, by iDynTree's step",
            everything / peer,
            "times",
            limit=RATIO,
        ),
    ]


def _estimate(given: Given) -> Callable[[], float]:
    """Return what measures one run [us] per sample."""

    def measure() -> float:
        estimation = Estimation(given, "floor")
        estimation.tare(TARE)
        start = process_time()
        estimation.run(lambda done: None)
        return (process_time() - start) / len(given.log) * 1e6

    return measure


def _peer(robot: Robot, log: SensorLog) -> Callable[[], float]:
    """Return what measures iDynTree's step [us] on the filtered samples of a log."""
    peer, (block,) = IdyntreeObserver.like(robot), LogFilter(log).blocks(len(log))
    frames = [block.frame(i) for i in range(len(block))]

    def measure() -> float:
        start = process_time()
        for frame in frames:
            peer.step_frame(frame)
        return (process_time() - start) / len(frames) * 1e6

    return measure


def _log(robot: Robot, size: int) -> SensorLog:
    plant = Plant(robot, "free", "realistic")
    for _ in range(SETTLING):
        plant.step()
    frames, stamps = [], []
    for tick in range(size):
        if tick == size // 2:
            plant.push(*PUSH, profile="half_sine", duration=size * 0.5e-3)
        plant.step()
        frames.append(plant.raw())
        stamps.append(plant.time)
    names = ("q", "motor_torque", "ft", "imu_gyro", "imu_acc")
    names += ("joint_valid", "ft_valid", "imu_valid")
    values = {name: np.array([getattr(frame, name) for frame in frames]) for name in names}
    return SensorLog(stamp=np.array(stamps), **values)
