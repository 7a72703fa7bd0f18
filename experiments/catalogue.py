"""The experiments by name. Each is a module with ``run(robot, seed, runs) -> Report``."""

from importlib import import_module
from inspect import signature
from typing import Any

from experiments.report import Report
from robot_model import Robot
from robot_model.names import did_you_mean

EXPERIMENTS = (
    "coverage",
    "external_wrench",
    "ft_prediction",
    "kinematic_sources",
    "residuals",
    "touch",
)


def require(name: str) -> str:
    """Return the name of an experiment, or raise LookupError that says which exist."""
    if name not in EXPERIMENTS:
        raise LookupError(f"no experiment '{name}'{did_you_mean(name, EXPERIMENTS)}")
    return name


def run_experiment(
    name: str, robot: Robot, seed: int, runs: int | None = None, **options: Any
) -> Report:
    """Run an experiment; as many runs as it takes by itself when None.

    Raises:
        LookupError: No such experiment.
        ValueError: The robot cannot serve for it, or it has no such option.
    """
    run = import_module(f"experiments.{require(name)}").run
    if foreign := sorted(set(options) - set(signature(run).parameters)):
        raise ValueError(f"{name} has no option {', '.join(foreign)}")
    return run(robot, seed, **({} if runs is None else {"runs": runs}), **options)
