"""The list of estimated external wrenches, and what of them the sensors leave open."""

from collections.abc import Mapping, Sequence

import numpy as np

from robot_model.messages import ExternalWrenches

from .html import AMBER, GREY, escape
from .table import Cell, table
from .touch_table import largest_deviation

TITLES = ("wrench at", "N", "± N", "N m", "± N m")
OPEN = "the sensors tell their sum only; these are the smallest that explain it"
NOTE = "Force and moment about the contact point; ±: along the worst direction."


def wrench_table(wrenches: ExternalWrenches | None, subtrees: Sequence[str]) -> str:
    """Return every contact with its wrench, those undecided marked and named below.

    ``subtrees``: names of the robot's sub-trees, in the order of the message's reasons.
    """
    if wrenches is None:
        return ""
    reasons = dict(zip(subtrees, wrenches.subtree_reasons, strict=False))
    unsure = undecided(wrenches)
    rows = [
        _row(wrenches, i, i in unsure) if valid else _missing(wrenches, i, reasons)
        for i, valid in enumerate(wrenches.valid)
    ]
    return table("wrenches", TITLES, rows, _note([wrenches.frame[i] for i in unsure]))


def undecided(wrenches: ExternalWrenches) -> list[int]:
    """Return the valid contacts of whose wrenches the sensors leave a part open."""
    decided = wrenches.decided or [True] * len(wrenches.frame)
    return [i for i in np.flatnonzero(wrenches.valid).tolist() if not decided[i]]


def _row(wrenches: ExternalWrenches, row: int, unsure: bool) -> list[Cell]:
    wrench, covariance = wrenches.wrench[row], wrenches.covariance[row]
    cells = [Cell(wrenches.frame[row], AMBER if unsure else "", wrenches.kind[row])]
    for half, digits in ((slice(3), 1), (slice(3, 6), 2)):
        size, spread = np.linalg.norm(wrench[half]), largest_deviation(covariance[half, half])
        cells += [Cell(f"{size:.{digits}f}"), Cell(f"{spread:.{digits}f}")]
    return cells


def _missing(wrenches: ExternalWrenches, row: int, reasons: Mapping[str, str]) -> list[Cell]:
    why = reasons.get(wrenches.subtree[row], "")
    return [Cell(wrenches.frame[row], GREY, why), *[Cell("--", GREY, why)] * 4]


def _note(frames: Sequence[str]) -> str:
    if not frames:
        return NOTE
    said = f"undecided: {', '.join(frames)}"
    return f'<b id="undecided" style="color:{AMBER}">{escape(said)}</b> ({OPEN}). {NOTE}'
