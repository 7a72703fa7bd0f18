"""Figures as tables of texts, for the terminal and for the document."""

from typing import NamedTuple

from benchmarks.rows import Row

HEADER = ["figure", "value", "unit", "peer", "ratio", "target", ""]


class Table(NamedTuple):
    """Lines below a header; all are texts."""

    title: str
    header: list[str]
    lines: list[list[str]]


def tables_of(rows: list[Row]) -> list[Table]:
    """Return the table of plain figures, then those of figures that have a cell in one."""
    plain = [row for row in rows if "cell" not in row]
    tables = [Table("", HEADER, [_line(row) for row in plain])] if plain else []
    names = dict.fromkeys(row["cell"][0] for row in rows if "cell" in row)
    return tables + [_pivot([row for row in rows if row.get("cell", [""])[0] == n]) for n in names]


def verdict(row: Row) -> str:
    """Return whether a target was met, or nothing where there is none."""
    return {True: "met", False: "missed", None: ""}[row["met"]]


def _line(row: Row) -> list[str]:
    numbers = [_number(row[key]) for key in ("value", "peer", "ratio")]
    value, peer, ratio = numbers
    return [row["name"], value, row["unit"], peer, ratio, row["target"] or "", verdict(row)]


def _pivot(rows: list[Row]) -> Table:
    """Return a table with the figures of each cell side by side."""
    title = rows[0]["cell"][0]
    columns = dict.fromkeys(row["cell"][2] for row in rows)
    lines = dict.fromkeys(row["cell"][1] for row in rows)
    cells = {
        key: [row for row in rows if tuple(row["cell"][1:]) == key]
        for key in ((line, column) for line in lines for column in columns)
    }
    table = [[line, *(_cell(cells[line, column]) for column in columns)] for line in lines]
    return Table(f"{title}{_statistics(rows)}", ["", *columns], table)


def _cell(rows: list[Row]) -> str:
    texts = []
    for row in rows:
        ratio = "" if row["ratio"] is None else f" (x {row['ratio']:.2f})"
        texts.append(f"{_number(row['value'])}{ratio}{' ' * bool(verdict(row))}{verdict(row)}")
    return " / ".join(texts)


def _statistics(rows: list[Row]) -> str:
    """Return what stands side by side in the cells, where that is the same in all of them."""
    found: dict[tuple[str, ...], list[str]] = {}
    for row in rows:
        found.setdefault(tuple(row["cell"]), []).append(row["name"].rpartition(", ")[2])
    first, *others = found.values()
    same = len(first) > 1 and all(other == first for other in others)
    return f": {' / '.join(first)}" if same else ""


def _number(value: float | None) -> str:
    if value is None:
        return ""
    if abs(value) < 1e-9:
        return "0"
    return f"{value:.0f}" if abs(value) >= 1000 else f"{value:.3g}"
