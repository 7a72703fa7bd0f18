"""The touch benchmark from its options to its report."""

from collections.abc import Callable, Sequence
from itertools import product
from pathlib import Path

from experiments.report import Report, csv_text, markdown_table, text_table
from experiments.touch import picture
from experiments.touch.conditions import (
    METHODS,
    PHYSICS,
    VARIANTS,
    Condition,
    checked,
    default_physics,
    drawn,
)
from experiments.touch.jobs import FREE, performed
from experiments.touch.store import Item, Record, Store
from experiments.touch.tables import Table, tables
from experiments.touch.targets import target_table
from robot_model import Robot

Progress = Callable[[int, int], None]  # runs done, of how many


def run(
    robot: Robot,
    seed: int = 1,
    runs: int = 40,
    physics: str | None = None,
    profiles: Sequence[str] = (),
    variants: Sequence[str] = (),
    methods: Sequence[str] = ("surface",),
    hours: float = 0.0,
    jobs: int = 1,
    draw: int | None = None,
    folder: Path | None = None,
    progress: Progress | None = None,
) -> Report:
    """Push a robot, or leave it alone, and return how the contact detector did.

    Args:
        robot: The robot.
        seed: Of everything; a run depends on it and on its index alone.
        runs: Pushes in each condition; 0 for none.
        physics: ``mujoco`` or ``pinocchio``; MuJoCo where it is installed when None.
        profiles: Noise profiles; ``realistic`` when there are only variants. Without
            both every run draws its condition.
        variants: See ``VARIANTS``.
        methods: How touches are located.
        hours: Of contact-free motion in each condition.
        jobs: Processes side by side.
        draw: Index of one run, which is repeated and drawn, under the last condition; no
            other is made.
        folder: Where results are kept; those that are there are not repeated, and the
            report is of all that are.
        progress: Told after every run.

    Raises:
        ValueError: An option has no such value.
    """
    physics = physics or default_physics()
    checked("physics", [physics], PHYSICS)
    checked("method", methods, METHODS)
    checked("variant", variants, tuple(VARIANTS))
    if draw is not None:
        item = _pushes(seed, draw + 1, physics, profiles, variants, methods)[-1]
        return picture.draw(robot, seed, draw, item.condition)
    items = _pushes(seed, runs, physics, profiles, variants, methods)
    items += _contact_free(seed, hours, physics, profiles, variants)
    store = Store(folder)
    missing = store.missing(items)
    for done, (item, score) in enumerate(performed(robot, missing, jobs), 1):
        store.add(item, score)
        if progress is not None:
            progress(done, len(missing))
    return report(store.records("push"), store.records("free"))


def _conditions(
    physics: str, profiles: Sequence[str], variants: Sequence[str], methods: Sequence[str]
) -> list[Condition]:
    pairs = product(profiles or ("realistic",), variants or ("usual",))
    return [Condition(physics, *pair, method) for pair in pairs for method in methods]


def _pushes(
    seed: int,
    runs: int,
    physics: str,
    profiles: Sequence[str],
    variants: Sequence[str],
    methods: Sequence[str],
) -> list[Item]:
    if profiles or variants:
        conditions = _conditions(physics, profiles, variants, methods)
        return [Item("push", seed, i, condition) for i in range(runs) for condition in conditions]
    return [
        Item("push", seed, i, Condition(physics, *drawn(seed, i), method))
        for i in range(runs)
        for method in methods
    ]


def _contact_free(
    seed: int, hours: float, physics: str, profiles: Sequence[str], variants: Sequence[str]
) -> list[Item]:
    single = [name for name in variants if VARIANTS[name].contacts == "one"]
    conditions = _conditions(physics, profiles, single, ("surface",))
    count = round(hours * 3600.0 / FREE)
    return [Item("free", seed, i, condition) for i in range(count) for condition in conditions]


def report(pushes: Sequence[Record], free: Sequence[Record]) -> Report:
    """Return the report of some results."""
    found = [target_table(pushes, free, method) for method in _methods(pushes)]
    found += tables(pushes, free)
    text = [line for table in found for line in text_table(*table)]
    listed = [{"title": t.title, "header": t.header, "rows": t.rows} for t in found]
    seeds = sorted({record["seed"] for record in (*pushes, *free)})
    figures = {"seeds": seeds, "pushes": len(pushes), "tables": listed}
    files = {"touch.md": _markdown(found), "touch.csv": _csv(found)}
    return Report("touch", figures, text, files)


def _methods(pushes: Sequence[Record]) -> list[str]:
    return sorted({record["method"] for record in pushes}, key=METHODS.index) or ["surface"]


def _markdown(found: Sequence[Table]) -> str:
    parts = [f"## {table.title}\n\n{markdown_table(table.header, table.rows)}" for table in found]
    return "# The touch benchmark\n\n" + "\n".join(parts)


def _csv(found: Sequence[Table]) -> str:
    return "\n".join(csv_text((table.title, *table.header[1:]), table.rows) for table in found)
