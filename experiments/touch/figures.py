"""What many pushes, or hours without one, come to."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from experiments.touch.store import Record

Array = np.ndarray
BINS = (0.0, 0.5, 0.7, 0.9, 0.97, 1.0)  # of probabilities


def column(records: Sequence[Record], name: str) -> Array:
    """Return one number of each record, (n,); nan where there is none."""
    return np.array([np.nan if r[name] is None else r[name] for r in records], dtype=float)


def share(records: Sequence[Record], name: str) -> float:
    return float(column(records, name).mean()) if records else np.nan


def quantile(records: Sequence[Record], name: str, level: float = 0.5) -> float:
    """Quantile of a number over the records that have it."""
    values = column(records, name)
    values = values[np.isfinite(values)]
    return float(np.quantile(values, level)) if values.size else np.nan


def standing(records: Sequence[Record]) -> list[Record]:
    """Return the pushes of which the robot did not fall."""
    return [record for record in records if not record["fell"]]


def push_figures(records: Sequence[Record]) -> dict[str, Any]:
    """Return the figures of some pushes; a push that was not located has no right link.

    Times in ms, points in mm, forces in N. Pushes that tipped the robot over do not count.
    """
    valid = standing(records)
    return {
        "pushes": len(valid),
        "fell": len(records) - len(valid),
        "early": share(valid, "early"),
        "detected": share(valid, "detected"),
        "delay": 1e3 * quantile(valid, "delay"),
        "delay_90": 1e3 * quantile(valid, "delay", 0.9),
        "limb": share(valid, "limb"),
        "first": share(valid, "first"),
        "among_three": share(valid, "among_three"),
        "point": 1e3 * quantile(valid, "point_error"),
        "point_90": 1e3 * quantile(valid, "point_error", 0.9),
        "force": quantile(valid, "force_error"),
        "force_90": quantile(valid, "force_error", 0.9),
        "step": 1e3 * quantile(valid, "step_time"),
        "locate": 1e3 * quantile(valid, "locate_time"),
    }


def free_figures(records: Sequence[Record]) -> dict[str, Any]:
    """Return the figures of contact-free motion."""
    hours = sum(record["seconds"] for record in records) / 3600.0
    alarms = sum(record["alarms"] for record in records)
    return {
        "hours": hours,
        "alarms": alarms,
        "per_hour": alarms / hours if hours else np.nan,
        "flagged": share(records, "flagged_share"),
        "limbs": " ".join(sorted({limb for record in records for limb in record["limbs"]})),
    }


def reliability(records: Sequence[Record]) -> list[dict[str, Any]]:
    """Of answers given with some probability, how many are right."""
    asked = [r for r in standing(records) if r["probabilities"]]
    given = np.array([r["probabilities"][0] for r in asked])
    return _by_bin(given, column(asked, "first"))


def none_reliability(records: Sequence[Record]) -> list[dict[str, Any]]:
    """Of touches said to be on none of the links with some probability, how many are on none
    of those listed."""
    asked = [r for r in standing(records) if r["probabilities"]]
    missed = [not set(r["links"]) <= set(r["ranking"]) for r in asked]
    return _by_bin(column(asked, "none_probability"), np.array(missed, dtype=float))


def _by_bin(given: Array, right: Array) -> list[dict[str, Any]]:
    rows = []
    for low, high in zip(BINS, BINS[1:], strict=False):
        mine = (given >= low) & ((given < high) | (high == BINS[-1]))
        if mine.any():
            mean, found = float(given[mine].mean()), float(right[mine].mean())
            name = f"{low:g} to {high:g}"
            rows.append({"bin": name, "n": int(mine.sum()), "given": mean, "right": found})
    return rows
