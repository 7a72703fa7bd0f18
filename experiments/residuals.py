"""The papers' residuals compared, as R does: Figures 3, 4, 7, 8 and 9, and its timing.

A sinusoidal force at the right shoulder of a standing robot, then one at each shoulder;
sensors are exact. "Real" is what the force does to the joints, J_fb^T f (eq. 12).
"""

from collections.abc import Callable

import numpy as np

from experiments.contact_candidates import ALIKE, Summary, summary
from experiments.line_figure import Panel, figure_svg
from experiments.report import Report, csv_text, markdown_table, text_table
from experiments.residual_run import GAIN, Push, Trace, pushed
from experiments.residual_timing import timings
from robot_model import Robot

Array = np.ndarray
NAME = "residuals"
SHOULDERS = ("r_shoulder_3", "l_shoulder_3")
AMPLITUDE = np.array([6.0, -9.0, 10.0])  # N, in the link's axes
SHOWN = ("r_knee", "l_knee", "torso_yaw")
INTERNAL = ("joint", "real", "internal", "classical")
CANDIDATES = ("body", "entries", "from the push [mm]", "largest torque misfit [N m]")
KNOWN = ("forces", "by", "median", "largest")


def run(robot: Robot, seed: int = 1, runs: int = 400) -> Report:
    """Compare the residuals of one and of two pushes, and time them.

    Args:
        robot: A robot that stands, with shoulders named as iCub's.
        seed: Of the pushes whose lines are cut, and of the postures that are timed.
        runs: How many of each.

    Raises:
        ValueError: There is no run, or the robot has no such links.
    """
    if runs < 1:
        raise ValueError(f"an experiment needs at least 1 run, got {runs}")
    if missing := [link for link in SHOULDERS if link not in robot.links]:
        raise ValueError(f"{robot.name} has no link {missing[0]}")
    places = [Push(link, np.zeros(3), AMPLITUDE) for link in SHOULDERS]
    one, two = pushed(robot, places[:1]), pushed(robot, places)
    inside, known = internal_rows(robot, one), known_rows(one, two)
    times = timings(robot, seed, runs)
    line, example = summary(robot, seed, runs)
    tables = {
        "Torque of one push, root mean square [N m]": (INTERNAL, inside),
        "Forces at known points, error [N]": (KNOWN, known),
        "The line of the force cut with the surface": (("figure", "value"), _line_rows(line)),
        "The candidates of one push": (CANDIDATES, example),
        "Time of one step [us]": (("step", "median", "of the internal's"), times),
    }
    figures = {
        "robot": robot.name, "gain": GAIN,
        "tables": {name: [list(head), *map(list, rows)] for name, (head, rows) in tables.items()},
    }  # fmt: skip
    text = [line for name, table in tables.items() for line in text_table(name, *table)]
    files = {f"{NAME}.md": _markdown(tables), f"{NAME}.csv": _csv(tables)}
    svg = {f"{NAME}_inside.svg": inside_figure(robot, one), f"{NAME}_force.svg": force_figure(one)}
    return Report(NAME, figures, text, files | svg)


def internal_rows(robot: Robot, trace: Trace) -> list[tuple]:
    """Root mean squares of the real torque, and of what each residual says wrongly."""
    truth, late = trace.true_internal, trace.filtered
    errors = trace.internal - late, trace.classical - late
    rows = []
    for name in SHOWN:
        i = robot.joints.index(name)
        rows.append((name, _rms(truth[:, i]), *(_rms(error[:, i]) for error in errors)))
    norms = (np.linalg.norm(values, axis=1) for values in (truth, *errors))
    rows.append(("norm of all", *(_rms(norm) for norm in norms)))
    lag = np.linalg.norm(trace.internal - truth, axis=1)
    return [*rows, ("norm, with the lag", _rms(np.linalg.norm(truth, axis=1)), _rms(lag),
                    _rms(np.linalg.norm(trace.classical - truth, axis=1)))]  # fmt: skip


def known_rows(one: Trace, two: Trace) -> list[tuple]:
    """Errors of forces at known points by eqs. (15), (19) and (20)."""
    found = [("one", "external (19)", one.external[:, None, :3], one)]
    for count, trace in (("one", one), ("two", two)):
        found.append((count, "classical (15)", _solved(trace, _classical), trace))
        found.append((count, "external and internal (20)", _solved(trace, _both), trace))
    rows = []
    for count, by, forces, trace in found:
        error = np.linalg.norm(forces - _delayed(trace), axis=2).max(axis=1)
        rows.append((count, by, float(np.median(error)), float(error.max())))
    return rows


def _solved(trace: Trace, equations: Callable[[Trace, int], tuple[Array, Array]]) -> Array:
    """Least-squares forces of every instant, (T, c, 3)."""
    solved = [np.linalg.lstsq(*equations(trace, t))[0] for t in range(len(trace.time))]
    return np.reshape(solved, (len(trace.time), -1, 3))


def _classical(trace: Trace, t: int) -> tuple[Array, Array]:
    """R eq. (15): all rows of the model with virtual joints, whose first six are (16)."""
    return trace.virtual_map[t], np.concatenate((trace.external[t], trace.classical[t]))


def _both(trace: Trace, t: int) -> tuple[Array, Array]:
    rows = np.vstack((trace.virtual_map[t, :6], trace.internal_map[t]))
    return rows, np.concatenate((trace.external[t], trace.internal[t]))


def _delayed(trace: Trace) -> Array:
    """True forces through the residuals' filter, (T, c, 3)."""
    late, blend = np.zeros_like(trace.forces), -np.expm1(-GAIN * 1e-3)
    for t in range(1, len(late)):
        late[t] = late[t - 1] + blend * (trace.forces[t] - late[t - 1])
    return late


def _line_rows(line: Summary) -> list[tuple]:
    return [
        ("pushes", line.pushes),
        ("bodies that a line enters, mean", line.bodies),
        ("entries, mean", line.entries),
        ("lines that enter the pushed body at a stored point [%]", 100.0 * line.cut),
        ("of these, the torques fit the pushed body best [%]", 100.0 * line.first),
        (f"of these, another body within {ALIKE} N m [%]", 100.0 * line.undecided),
    ]


def _rms(values: Array) -> float:
    return float(np.sqrt(np.mean(values**2)))


def inside_figure(robot: Robot, trace: Trace) -> str:
    """R Figures 3 and 4 in one: real torque, and what the two residuals say."""
    panels = []
    for name in SHOWN:
        i = robot.joints.index(name)
        lines = trace.true_internal[:, i], trace.internal[:, i], trace.classical[:, i]
        labels = ("real", "internal", "classical")
        panels.append(Panel(f"{name} [N m]", dict(zip(labels, lines, strict=True))))
    errors = {
        label: np.linalg.norm(values - trace.true_internal, axis=1)
        for label, values in (("internal", trace.internal), ("classical", trace.classical))
    }
    panels.append(Panel("norm of the error [N m]", {"real": np.zeros(len(trace.time)), **errors}))
    return figure_svg("A force at the right shoulder, felt by the joints", trace.time, panels)


def force_figure(trace: Trace) -> str:
    """R Figures 7 and 8: the force by the external residual."""
    panels = [
        Panel(
            f"force {axis} [N], base axes",
            {"real": trace.forces[:, 0, i], "external residual": trace.external[:, i]},
        )
        for i, axis in enumerate("xyz")
    ]
    error = np.linalg.norm(trace.external[:, :3] - trace.forces[:, 0], axis=1)
    zero = np.zeros(len(error))
    panels.append(Panel("norm of the error [N]", {"real": zero, "external residual": error}))
    return figure_svg("A force at the right shoulder, by eq. (19)", trace.time, panels)


def _markdown(tables: dict[str, tuple[tuple[str, ...], list[tuple]]]) -> str:
    parts = [f"## {name}\n\n{markdown_table(*table)}" for name, table in tables.items()]
    return "# Residuals\n\n" + "\n".join(parts)


def _csv(tables: dict[str, tuple[tuple[str, ...], list[tuple]]]) -> str:
    return "\n".join(csv_text((name, *head[1:]), rows) for name, (head, rows) in tables.items())
