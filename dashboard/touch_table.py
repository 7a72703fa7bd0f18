"""The ranked list of where a touch may be."""

from typing import Any

import numpy as np

from robot_model.messages import Contacts

from .table import Cell, table

SHOWN = 5  # hypotheses at most
FAINT = 0.005  # probability that would read 0.00
TITLES = ("touch", "p", "N", "± N", "point [mm]", "± mm")
NOTE = (
    "Point in the axes of the first link; ±: one standard deviation along the direction in"
    " which it is largest. Links joined by &quot;or&quot; cannot be told apart."
)


def touch_table(contacts: Contacts | None) -> str:
    """Return hypotheses, best first, and how probable it is that none of them is right."""
    hypotheses = [] if contacts is None else contacts.hypotheses
    if contacts is None or not hypotheses:
        return ""
    likely = [one for one in hypotheses[1:SHOWN] if one["probability"] >= FAINT]
    rows = [_row(one) for one in (hypotheses[0], *likely)]
    none = [Cell("none of these"), Cell(f"{contacts.none_probability:.2f}")]
    return table("touches", TITLES, [*rows, none], NOTE)


def _row(hypothesis: dict[str, Any]) -> list[Cell]:
    covariance = np.array(hypothesis["covariance"], dtype=float)
    point = " ".join(str(round(1e3 * value)) for value in hypothesis["point"])
    return [
        Cell(" or ".join(hypothesis["links"])),
        Cell(f"{hypothesis['probability']:.2f}"),
        Cell(f"{np.linalg.norm(hypothesis['force']):.1f}"),
        Cell(f"{largest_deviation(covariance[3:, 3:]):.1f}"),
        Cell(point),
        Cell(f"{1e3 * largest_deviation(covariance[:3, :3]):.0f}"),
    ]


def largest_deviation(covariance: np.ndarray) -> float:
    """Return the standard deviation along the worst direction, given a covariance (m, m)."""
    return float(np.sqrt(max(np.linalg.eigvalsh(covariance)[-1], 0.0)))
