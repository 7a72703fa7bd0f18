"""The benchmark's tables: by condition, and the usual condition by force, place, motion, kind."""

from collections.abc import Callable, Sequence
from itertools import groupby
from typing import Any, NamedTuple

import numpy as np

from experiments.touch.figures import (
    free_figures,
    none_reliability,
    push_figures,
    reliability,
)
from experiments.touch.store import Record

HEADER = {
    "pushes": "n",
    "fell": "fell",
    "early": "flagged before",
    "detected": "detected",
    "delay": "delay [ms]",
    "delay_90": "90 %",
    "limb": "limb",
    "first": "link",
    "among_three": "top 3",
    "point": "point [mm]",
    "point_90": "90 % ",
    "force": "force [N]",
    "force_90": " 90 %",
    "step": "step [ms]",
    "locate": "locate [ms]",
}
SHARES = {"early", "detected", "limb", "first", "among_three", "given", "right", "flagged"}
FORCES = (5.0, 10.0, 20.0, 40.0)  # N, bounds of bands


class Table(NamedTuple):
    """A table of text."""

    title: str
    header: tuple[str, ...]
    rows: list[tuple[str, ...]]


def tables(pushes: Sequence[Record], free: Sequence[Record]) -> list[Table]:
    """Return all tables of some results."""
    found = [_grouped("By condition", pushes, _condition)] if pushes else []
    for condition, records in _groups(pushes, _condition):
        if len(records) >= 20 and len(records[0]["links"]) == 1:
            found += _details(condition, records)
    if free:
        found.append(_free_table(free))
    return found


def _details(condition: str, records: Sequence[Record]) -> list[Table]:
    by = {
        "force [N]": _band,
        "place": lambda record: record["subtrees"][0],
        "motion": lambda record: record["motion"],
        "kind of push": lambda record: record["kind"],
    }
    found = [_grouped(f"{condition}: by {what}", records, key) for what, key in by.items()]
    rows = [_cells(row, tuple(row)) for row in reliability(records)]
    header = ("probability", "n", "given", "right")
    found.append(Table(f"{condition}: is the first link right?", header, rows))
    rows = [_cells(row, tuple(row)) for row in none_reliability(records)]
    header = ("none_probability", "n", "given", "on no listed link")
    found.append(Table(f"{condition}: is it on none of the links listed?", header, rows))
    return [*found, _missed(condition, records)]


def _missed(condition: str, records: Sequence[Record]) -> Table:
    """The pushes of which another link, or none, came first."""
    header = ("seed/index", "motion", "kind", "force [N]", "link", "taken for", "p", "point [mm]")
    rows = []
    for r in records:
        if r["first"] or r["fell"]:
            continue
        named = r["ranking"][0] if r["ranking"] else "nothing"
        probability = f"{r['probabilities'][0]:.2f}" if r["ranking"] else "-"
        error = "-" if r["point_error"] is None else f"{1e3 * r['point_error']:.0f}"
        where = f"{r['seed']}/{r['index']}", r["motion"], r["kind"], f"{r['forces'][0]:.1f}"
        rows.append((*where, r["links"][0], named, probability, error))
    return Table(f"{condition}: pushes of which the link was missed", header, rows)


def _grouped(title: str, records: Sequence[Record], key: Callable[[Record], str]) -> Table:
    rows = [
        (name.strip(), *_cells(push_figures(mine), tuple(HEADER)))
        for name, mine in _groups(records, key)
    ]
    return Table(title, ("", *HEADER.values()), rows)


def _free_table(free: Sequence[Record]) -> Table:
    def named(record: Record) -> str:
        return f"{_condition(record)}, {record['motion']}"

    groups = [
        *_groups(free, named),
        *((f"{name}, all", m) for name, m in _groups(free, _condition)),
    ]
    columns = ("hours", "alarms", "per_hour", "flagged", "limbs")
    rows = [(name, *_cells(free_figures(mine), columns)) for name, mine in groups]
    header = ("", "hours", "alarms", "per hour", "time flagged", "limbs")
    return Table("Contact-free motion", header, rows)


def _groups(
    records: Sequence[Record], key: Callable[[Record], str]
) -> list[tuple[str, list[Record]]]:
    return [(name, list(mine)) for name, mine in groupby(sorted(records, key=key), key)]


def _condition(record: Record) -> str:
    return ", ".join(record[name] for name in ("profile", "variant", "method", "physics"))


def _band(record: Record) -> str:
    force = min(record["forces"])
    i = int(np.clip(np.searchsorted(FORCES, force, "right") - 1, 0, len(FORCES) - 2))
    return f"{FORCES[i]:2g} to {FORCES[i + 1]:2g}"


def _cells(figures: dict[str, Any], columns: Sequence[str]) -> tuple[str, ...]:
    return tuple(_text(figures[name], name) for name in columns)


def _text(value: Any, name: str) -> str:
    if isinstance(value, float) and not np.isfinite(value):
        return "-"
    if name in SHARES:
        return f"{100.0 * value:.1f} %"
    return f"{value:.3g}" if isinstance(value, float) else str(value)
