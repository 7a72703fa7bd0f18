"""`wrenchbus estimate` over a log of the simulated robot, per sample of one core

1 kHz, `realistic` sensors, positions only; 100 us are ten times real time. The robot stands
untouched but for one push in half of the log.
"""

from dataclasses import replace
from time import process_time

import numpy as np

from benchmarks.rows import Row, row
from deploy.estimate.given import Given
from deploy.estimate.run import Estimation
from estimation.offline.sensor_log import SensorLog
from robot_model import Robot, load_robot
from robot_sim import Plant

SETTLING, SIZE, ROUNDS = 4000, 4000, 5
TARE = 1.0  # s
LIMIT = 100.0  # us
PUSH = ("l_forearm", np.array([0.05, -0.01, -0.034]), np.array([-4.0, 1.2, 11.0]))


def run(quick: bool = False) -> list[Row]:
    """Return the fastest of some runs, with and without residuals and contacts."""
    robot = load_robot("icub")
    log = _log(robot, 1500 if quick else SIZE)
    rounds = 2 if quick else ROUNDS
    observed = _microseconds(Given(replace(log, motor_torque=None), robot), rounds)
    everything = _microseconds(Given(log, robot), rounds)
    return [
        row("torques and wrenches, with standard deviations", observed, "us", limit=LIMIT),
        row("residuals and contacts too", everything, "us", limit=LIMIT),
    ]


def _microseconds(given: Given, rounds: int) -> float:
    times = []
    for _ in range(rounds):
        estimation = Estimation(given, "floor")
        estimation.tare(TARE)
        start = process_time()
        estimation.run(lambda done: None)
        times.append(process_time() - start)
    return min(times) / len(given.log) * 1e6


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
