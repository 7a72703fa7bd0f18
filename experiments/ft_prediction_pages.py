"""Tables and figure of the experiment ``ft_prediction``."""

from typing import Any

import numpy as np

from experiments.conditions import COMPONENTS, Case, Errors
from experiments.line_figure import Panel, figure_svg
from experiments.published import TABLE_4_1
from experiments.report import csv_text, markdown_table
from robot_model import Robot

Array = np.ndarray


def lines(robot: Robot, summary: dict[str, Errors]) -> list[str]:
    """Norms of force and moment: mean and standard deviation, by condition and sensor."""
    found = ["predicted minus measured: |mean| and |std| of the force [N] and the moment [N m]"]
    for condition, errors in summary.items():
        for i, sensor in enumerate(robot.ft_sensors):
            parts = [values[i, half] for half in (slice(3), slice(3, 6)) for values in errors]
            numbers = " ".join(f"{np.linalg.norm(part):9.2g}" for part in parts)
            found.append(f"{condition:30s} {sensor:12s} {numbers}")
    return found


def csv(robot: Robot, statistics: dict[Case, Errors]) -> str:
    """Mean and standard deviation of every run."""
    rows = [
        (sensor, case.condition, case.run, statistic, *map(float, values[i]))
        for i, sensor in enumerate(robot.ft_sensors)
        for case, errors in statistics.items()
        for statistic, values in zip(Errors._fields, errors, strict=True)
    ]
    return csv_text(["sensor", "condition", "run", "statistic", *COMPONENTS], rows)


def page(robot: Robot, summary: dict[str, Errors]) -> str:
    """Tables with the published figures, where there are any: norms, then components."""
    published = {f"thesis, {robot.name}": TABLE_4_1} if robot.name == "icub" else {}
    force, moment = (_norms(robot, summary, published, half) for half in (slice(3), slice(3, 6)))
    parts = [
        "# Predicted minus measured F/T readings",
        "Written by `wrenchbus experiment ft_prediction`.",
        "Cells are mean / standard deviation; several runs: root mean squares over the runs.",
        f"Norm of the force [N]\n\n{force}\nNorm of the moment [N m]\n\n{moment}",
    ]
    for i, sensor in enumerate(robot.ft_sensors):
        columns = {name: table[sensor] for name, table in published.items() if sensor in table}
        columns |= {name: (mean[i], std[i]) for name, (mean, std) in summary.items()}
        rows = [
            [name, *(f"{m:.3f} / {s:.3f}" for m, s in zip(mean, std, strict=True))]
            for name, (mean, std) in columns.items()
        ]
        parts.append(f"`{sensor}` [N], [N m]\n\n{markdown_table(['', *COMPONENTS], rows)}")
    return "\n\n".join(part.strip("\n") for part in parts) + "\n"


def _norms(
    robot: Robot,
    summary: dict[str, Errors],
    published: dict[str, dict[str, Array]],
    half: slice,
) -> str:
    """Norms of forces or moments: sensors by conditions."""
    rows = []
    for i, sensor in enumerate(robot.ft_sensors):
        pairs = [table.get(sensor) for table in published.values()]
        pairs += [(mean[i], std[i]) for mean, std in summary.values()]
        rows.append([sensor, *(_norm_pair(pair, half) for pair in pairs)])
    return markdown_table(["", *published, *summary], rows)


def _norm_pair(pair: Any, half: slice) -> str:
    return "" if pair is None else " / ".join(f"{np.linalg.norm(v[half]):.2g}" for v in pair)


def figure(robot: Robot, readings: Array, period: float) -> str:
    """Figure 4.10: reading and prediction of the first sensor, (T, 2, k, 6) every period [s]."""
    predicted, measured = readings[:, 0, 0], readings[:, 1, 0]
    panels = [
        Panel(
            f"{name} [{'N' if i < 3 else 'N m'}]",
            {"measured": measured[:, i], "predicted": predicted[:, i]},
        )
        for i, name in enumerate(COMPONENTS)
    ]
    time = np.arange(len(readings)) * period
    title = f"{robot.ft_sensors[0]}: reading and prediction, realistic sensors"
    return figure_svg(title, time, panels)
