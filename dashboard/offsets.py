"""What the page says of the force/torque sensors' offsets."""

from collections.abc import Sequence
from typing import Any

from .html import escape
from .table import Cell, table

TITLES = ("offset of", "N", "N m", "spread N", "N m")


def offset_table(observer: dict[str, Any]) -> str:
    """Return offset and spread of each sensor, given the observer's status (empty: none)."""
    if "offset" not in observer:
        return ""
    tare = observer.get("tare", {})
    spread = tare.get("spread", {})
    rows = [_row(name, offset, spread.get(name)) for name, offset in observer["offset"].items()]
    return table("offsets", TITLES, rows, _note(tare))


def _row(name: str, offset: Sequence[float], spread: Sequence[float] | None) -> list[Cell]:
    force, moment = _numbers(offset[:3], 1), _numbers(offset[3:], 2)
    widest = ("", "") if spread is None else (f"{max(spread[:3]):.2f}", f"{max(spread[3:]):.3f}")
    hint = "" if spread is None else _numbers(spread, 3)
    return [Cell(name), Cell(force), Cell(moment), *(Cell(text, hint=hint) for text in widest)]


def _numbers(values: Sequence[float], digits: int) -> str:
    return " ".join(f"{value:.{digits}f}" for value in values)


def _note(tare: dict[str, Any]) -> str:
    if not tare.get("date"):
        return "Not tared."
    said = f"Tare of {tare['date']} on {tare['stance']}, {tare['samples']} samples."
    return escape(f"{said} {tare['error']}" if tare.get("error") else said)
