"""One measured figure, as it goes into ``results.json``."""

from collections.abc import Sequence
from typing import Any

import numpy as np

Row = dict[str, Any]
ENOUGH = 3  # samples that must lie beyond a percentile, else it is not one


def row(
    name: str,
    value: float,
    unit: str,
    peer: float | None = None,
    limit: float | None = None,
    goal: float | None = None,
    cell: tuple[str, str, str] | None = None,
) -> Row:
    """Return a figure.

    Args:
        peer: The same of somebody else, in the same unit.
        limit: What the value may be at most; without one there is no target.
        goal: What we would like.
        cell: Table, line and column in the document; figures of one cell stand side by side.
    """
    ratio = None if peer is None else value / peer
    figure: Row = {"name": name, "value": value, "unit": unit, "peer": peer, "ratio": ratio}
    if limit is not None:
        wish = "" if goal is None else f" (goal {goal:g})"
        figure |= {"target": f"<= {limit:g} {unit}{wish}", "met": bool(value <= limit)}
    return figure if cell is None else figure | {"cell": cell}


def percentiles(values: Sequence[float]) -> dict[str, float]:
    """Return p50, p99 and p99.9, as far as there are values enough, and the largest one."""
    if not values:
        return {}
    wanted = {"p50": 50.0, "p99": 99.0, "p99.9": 99.9}
    told = {
        name: float(np.percentile(values, percent))
        for name, percent in wanted.items()
        if len(values) * (100.0 - percent) >= 100.0 * ENOUGH
    }
    return told | {"max": float(max(values))}
