"""External wrench and torques of known stimuli at the hand (thesis, Figures 4.11 and 4.12).

The thesis compares what the arm's sensor tells with a second sensor in the palm. Here the
plant tells what it exerts: w and J' w, eq. (4.3.1). The estimate of the torques is their
change since the robot rested untouched, as there.
"""

from collections.abc import Sequence

import numpy as np

from experiments.conditions import (
    COMPONENTS,
    REALISTIC,
    Case,
    Errors,
    by_case,
    by_condition,
    listed,
    pole_runs,
)
from experiments.hand_touch import EVERY, Limb, Sample, first_limb, touch
from experiments.line_figure import Panel, figure_svg
from experiments.report import Report, csv_text, markdown_table
from experiments.stimulus import Stimulus, stimuli
from robot_model import Robot

Array = np.ndarray
NAME = "external_wrench"
SHOWN = Case(REALISTIC, 0)


def run(
    robot: Robot, seed: int = 1, runs: int = 3, exerted: Sequence[Stimulus] | None = None
) -> Report:
    """Exert known wrenches on the end of the first sensor's limb, and compare.

    Args:
        robot: A robot with force/torque sensors.
        seed: Of the biases and mass errors of the first run.
        runs: How many draws of them.
        exerted: Wrenches, one after the other; those of ``stimuli`` when None.

    Raises:
        ValueError: The robot has no force/torque sensor, or there is no run.
    """
    if not robot.ft_sensors:
        raise ValueError(f"{robot.name} has no force/torque sensor")
    limb = first_limb(robot)
    exerted = stimuli() if exerted is None else exerted
    pairs: dict[Case, tuple[Sample, Sample]] = {}
    for pole_run in pole_runs(robot, seed, runs):
        pairs |= touch(pole_run, limb, exerted)
    statistics = by_case({c: list(_errors(pair, limb)) for c, pair in pairs.items()})
    summary = by_condition(statistics)
    names = _names(robot, limb)
    about = {"robot": robot.name, "frame": limb.frame, "seed": seed, "runs": runs}
    return Report(
        name=NAME,
        figures=about | {"columns": [list(name) for name in names]} | listed(statistics, summary),
        lines=_lines(limb, summary),
        files={
            f"{NAME}.csv": _csv(names, statistics),
            f"{NAME}.md": _table(names, summary),
            f"{NAME}.svg": _wrench_figure(limb, pairs[SHOWN]),
            "external_torque.svg": _torque_figure(robot, limb, pairs[SHOWN]),
        },
    )


def _errors(pair: tuple[Sample, Sample], limb: Limb) -> Array:
    """Estimate minus truth, (T, 6 + 2 j): wrench, external torques, link torques."""
    truth, estimate = pair
    wrench, external, link = (e - t for e, t in zip(estimate, truth, strict=True))
    return np.hstack([wrench, external[:, limb.joints], link[:, limb.joints]])


def _names(robot: Robot, limb: Limb) -> list[tuple[str, str]]:
    """What the columns of the errors are: quantity and component."""
    joints = [robot.joints[i] for i in limb.joints]
    wrench = [("external wrench", name) for name in COMPONENTS]
    external = [("external torque", name) for name in joints]
    return wrench + external + [("link torque", name) for name in joints]


def _lines(limb: Limb, summary: dict[str, Errors]) -> list[str]:
    j = len(limb.joints)
    blocks = {
        "force [N]": slice(0, 3),
        "moment [N m]": slice(3, 6),
        "external torque [N m]": slice(6, 6 + j),
        "link torque [N m]": slice(6 + j, None),
    }
    lines = [f"estimate minus truth at {limb.frame}: largest |mean| and std of a component"]
    for condition, (mean, std) in summary.items():
        for what, part in blocks.items():
            numbers = f"{mean[part].max():9.2g} {std[part].max():9.2g}"
            lines.append(f"{condition:30s} {what:22s} {numbers}")
    return lines


def _csv(names: list[tuple[str, str]], statistics: dict[Case, Errors]) -> str:
    rows = [
        (*name, case.condition, case.run, float(errors.mean[i]), float(errors.std[i]))
        for i, name in enumerate(names)
        for case, errors in statistics.items()
    ]
    return csv_text(["quantity", "component", "condition", "run", "mean", "std"], rows)


def _table(names: list[tuple[str, str]], summary: dict[str, Errors]) -> str:
    """Mean / standard deviation of each component under each condition."""
    title = "# Estimate minus truth of known wrenches at a hand"
    told = "Written by `wrenchbus experiment external_wrench`. Cells are mean / standard deviation"
    told += " [N], [N m];\nseveral runs: root mean squares over the runs."
    rows = []
    for i, (quantity, component) in enumerate(names):
        cells = [f"{mean[i]:.3f} / {std[i]:.3f}" for mean, std in summary.values()]
        rows.append([quantity, component, *cells])
    table = markdown_table(["quantity", "component", *summary], rows)
    return f"{title}\n\n{told}\n\n{table}"


def _wrench_figure(limb: Limb, pair: tuple[Sample, Sample]) -> str:
    truth, estimate = pair
    panels = [
        Panel(
            f"{name} [{'N' if i < 3 else 'N m'}]",
            {"exerted": truth.wrench[:, i], "estimated": estimate.wrench[:, i]},
        )
        for i, name in enumerate(COMPONENTS)
    ]
    title = f"External wrench at {limb.frame}, realistic sensors"
    return figure_svg(title, _time(truth), panels)


def _torque_figure(robot: Robot, limb: Limb, pair: tuple[Sample, Sample]) -> str:
    truth, estimate = pair
    panels = [
        Panel(
            f"{robot.joints[i]} [N m]",
            {"J' w": truth.external_torque[:, i], "estimated": estimate.external_torque[:, i]},
        )
        for i in limb.joints
    ]
    title = f"External torques of a wrench at {limb.frame}, realistic sensors"
    return figure_svg(title, _time(truth), panels)


def _time(samples: Sample) -> Array:
    return np.arange(len(samples.wrench)) * EVERY * 1e-3
