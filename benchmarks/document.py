"""Writes ``docs/performance.md`` from the stored figures.

By itself (``python -m benchmarks.document``) it renders them again, without measuring.
"""

from importlib import import_module
from inspect import getdoc
from pathlib import Path

from benchmarks.machine import describe
from benchmarks.results import read
from benchmarks.rows import Row
from benchmarks.tables import Table, tables_of

DOCUMENT = Path(__file__).parent.parent / "docs" / "performance.md"
ORDER = ("bus_latency", "bus_scale", "bus_fan_out", "bus_reliable", "bus_memory", "bus_memory_long")
ORDER += ("bus_reconnect", "bus_names", "codec", "system")  # the others follow
HEAD = """# Performance

Written by `make bench` from the figures that it stores in `benchmarks/results.json`; do not edit.
Every figure is measured beside its peer in one run, in turns: on a busy or slow machine trust the
ratios, not the times. "Cores busy" counts everybody on the machine while the figure was taken,
the benchmark itself included. Where a peer is named without more, `ratio` is value by peer, and
less than 1 means that we are faster. Targets that the stored runs missed stand first. The latency
and fan-out parts take real-time priority where they may: others on the machine notice it.

Machine: {machine}.
"""


def write() -> None:
    """Write the document."""
    rows = read()
    measured = dict.fromkeys(row["bench"] for row in rows)
    names = [name for name in ORDER if name in measured]
    names += sorted(name for name in measured if name not in names)
    sections = [_section(name, [r for r in rows if r["bench"] == name]) for name in names]
    parts = [HEAD.format(machine=describe()), _missed(rows), *sections]
    DOCUMENT.write_text("\n".join(parts))


def _missed(rows: list[Row]) -> str:
    missed = [row for row in rows if row["met"] is False]
    met = sum(row["met"] is True for row in rows)
    lines = [f"{met} targets met, {len(missed)} missed{':' if missed else '.'}", ""]
    for row in missed:
        lines.append(f"- {row['name']}: {row['value']:.3g} {row['unit']}, target {row['target']}")
    return "\n".join([*lines, ""])


def _section(name: str, rows: list[Row]) -> str:
    title, _, text = (getdoc(import_module(f"benchmarks.bench_{name}")) or name).partition("\n")
    quick = ", a quick run with rough figures" if rows[0]["quick"] else ""
    nice = f", at nice {rows[0]['nice']}" if rows[0].get("nice") else ""
    when = f"Measured {rows[0]['measured']}, {rows[0]['load']:.1f} cores busy{nice}{quick}."
    parts = [f"## {title.rstrip('.')}", text.strip(), when, *map(_markdown, tables_of(rows))]
    return "\n\n".join(part for part in parts if part) + "\n"


def _markdown(table: Table) -> str:
    lines = [table.header, ["---"] * len(table.header), *table.lines]
    text = "\n".join(f"| {' | '.join(line)} |" for line in lines)
    return f"{table.title}\n\n{text}" if table.title else text


if __name__ == "__main__":
    write()
