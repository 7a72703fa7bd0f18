"""The conditions under which the thesis is repeated: sensors and masses, right and wrong."""

from collections.abc import Iterator, Mapping
from typing import Any, NamedTuple

import numpy as np

from experiments.pole_run import PoleRun
from robot_model import Robot

Array = np.ndarray
IDEAL, MASS, REALISTIC = "ideal", "mass error", "realistic"
BOTH, UNTARED = "realistic, mass error", "realistic, mass error, no tare"
CONDITIONS = (IDEAL, MASS, REALISTIC, BOTH, UNTARED)
MASS_ERROR = 0.02  # of a link's mass, at most; the observer's model has it, the plant not
COMPONENTS = ("fx", "fy", "fz", "mx", "my", "mz")


class Case(NamedTuple):
    """A condition, and which draw of biases and mass errors."""

    condition: str
    run: int


def pole_runs(robot: Robot, seed: int, runs: int) -> Iterator[PoleRun[Case]]:
    """Prepare one plant with exact sensors, and ``runs`` with realistic ones.

    Observers watch each with the right masses and with masses that are wrong by up to
    ``MASS_ERROR``; all but those of ``UNTARED`` are tared at the start.

    Raises:
        ValueError: There is no run.
    """
    if runs < 1:
        raise ValueError(f"an experiment needs at least 1 run, got {runs}")
    wrong = [robot.perturbed(seed + i, MASS_ERROR) for i in range(runs)]
    masses = {Case(MASS, i): wrong[i] for i in range(runs)}
    yield _tared(PoleRun(robot, "ideal", seed, {Case(IDEAL, 0): robot} | masses))
    for i in range(runs):
        believed = {Case(REALISTIC, i): robot, Case(BOTH, i): wrong[i], Case(UNTARED, i): wrong[i]}
        yield _tared(PoleRun(robot, "realistic", seed + i, believed))


def _tared(run: PoleRun[Case]) -> PoleRun[Case]:
    run.tare([case for case in run.observers if case.condition != UNTARED])
    return run


class Errors(NamedTuple):
    """Mean and standard deviation over a run, or their root mean squares over runs."""

    mean: Array
    std: Array

    def listed(self) -> dict[str, Any]:
        return {"mean": self.mean.tolist(), "std": self.std.tolist()}


def by_case(errors: Mapping[Case, list[Array]]) -> dict[Case, Errors]:
    """Return the statistics over time of each case's errors (T, ...)."""
    return {
        case: Errors(np.mean(samples, axis=0), np.std(samples, axis=0))
        for case, samples in errors.items()
    }


def by_condition(statistics: Mapping[Case, Errors]) -> dict[str, Errors]:
    """Return the root mean squares over the runs of each condition."""
    found = {}
    for condition in CONDITIONS:
        runs = [errors for case, errors in statistics.items() if case.condition == condition]
        means, stds = (np.array(values) for values in zip(*runs, strict=True))
        found[condition] = Errors(np.sqrt((means**2).mean(0)), np.sqrt((stds**2).mean(0)))
    return found


def listed(statistics: Mapping[Case, Errors], summary: Mapping[str, Errors]) -> dict[str, Any]:
    """Return both as JSON carries them."""
    return {
        "rms_over_runs": {name: errors.listed() for name, errors in summary.items()},
        "by_run": [case._asdict() | errors.listed() for case, errors in statistics.items()],
    }
