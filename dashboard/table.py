"""Small tables."""

from collections.abc import Iterable, Sequence
from typing import NamedTuple

from .html import GREY, escape

CELL = "padding:1px 5px;text-align:right;white-space:nowrap"
LEFT = "padding:1px 5px;text-align:left;overflow-wrap:anywhere"


class Cell(NamedTuple):
    """One text; ``colour`` and ``hint`` (shown under the pointer) may be empty."""

    text: str
    colour: str = ""
    hint: str = ""


def table(identifier: str, titles: Sequence[str], rows: Iterable[Sequence[Cell]], note: str) -> str:
    """Return a table, its first column at the left, the others at the right, and a note below."""
    head = "".join(
        _cell("th", Cell(title), i, f"color:{GREY};font-weight:500")
        for i, title in enumerate(titles)
    )
    body = "".join(f"<tr>{_row(row)}</tr>" for row in rows)
    return (
        f'<div id="{identifier}" style="padding:0 6px;font:11px/1.35 system-ui,sans-serif">'
        f'<table style="border-collapse:collapse;width:100%"><tr>{head}</tr>{body}</table>'
        f'<p style="color:{GREY}">{note}</p></div>'
    )


def _row(cells: Sequence[Cell]) -> str:
    return "".join(_cell("td", cell, i) for i, cell in enumerate(cells))


def _cell(tag: str, cell: Cell, column: int, style: str = "") -> str:
    colour = f"color:{cell.colour}" if cell.colour else style
    hint = f' title="{escape(cell.hint)}"' if cell.hint else ""
    place = CELL if column else LEFT
    return f'<{tag} style="{place};{colour}"{hint}>{escape(cell.text)}</{tag}>'
