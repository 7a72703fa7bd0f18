"""Model against measured F/T in a moving sequence (thesis, Table 4.1 and Figure 4.10).

Nothing touches the limbs: every reading follows from the model and the motion alone, and
what a sensor reads otherwise is the error.
"""

import numpy as np

from experiments import ft_prediction_pages as pages
from experiments.conditions import (
    COMPONENTS,
    REALISTIC,
    Case,
    by_case,
    by_condition,
    listed,
    pole_runs,
)
from experiments.limb_motion import LimbMotion
from experiments.pole_run import PoleRun
from experiments.report import Report
from robot_model import Robot

Array = np.ndarray
NAME = "ft_prediction"
EVERY = 10  # ticks of 1 ms between samples
SHOWN = Case(REALISTIC, 0)


def run(robot: Robot, seed: int = 1, runs: int = 3, postures: int = 5) -> Report:
    """Move the limbs through a sequence of postures and compare.

    Args:
        robot: A robot with force/torque sensors.
        seed: Of the postures, and of the biases and mass errors of the first run.
        runs: How many draws of biases and mass errors.
        postures: Length of the sequence.

    Raises:
        ValueError: The robot has no force/torque sensor, or there is no run.
    """
    if not robot.ft_sensors:
        raise ValueError(f"{robot.name} has no force/torque sensor that could be predicted")
    motion = LimbMotion(robot, seed, postures)
    readings: dict[Case, Array] = {}
    for pole_run in pole_runs(robot, seed, runs):
        readings |= _move(pole_run, motion)
    errors = {case: list(pair[:, 0] - pair[:, 1]) for case, pair in readings.items()}
    statistics = by_case(errors)
    summary = by_condition(statistics)
    about = {"robot": robot.name, "sensors": list(robot.ft_sensors), "seed": seed, "runs": runs}
    return Report(
        name=NAME,
        figures=about | {"components": list(COMPONENTS)} | listed(statistics, summary),
        lines=pages.lines(robot, summary),
        files={
            f"{NAME}.csv": pages.csv(robot, statistics),
            f"{NAME}.md": pages.page(robot, summary),
            f"{NAME}.svg": pages.figure(robot, readings[SHOWN], EVERY * 1e-3),
        },
    )


def _move(pole_run: PoleRun[Case], motion: LimbMotion) -> dict[Case, Array]:
    """Return predicted and measured readings, (T, 2, k, 6) by case."""
    found: dict[Case, list[Array]] = {case: [] for case in pole_run.observers}
    for tick in range(round(motion.duration * 1e3)):
        pole_run.plant.command(motion.position(tick * 1e-3))
        pole_run.tick()
        if tick % EVERY == 0:
            for case, estimate in pole_run.estimates().items():
                found[case].append(np.stack([estimate.predicted, estimate.measured]))
    return {case: np.array(samples) for case, samples in found.items()}
