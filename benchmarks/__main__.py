"""Runs benchmarks, prints their figures, stores them in ``benchmarks/results.json``.

A full run also writes ``docs/performance.md``; a quick one leaves it alone.
"""

import argparse
import sys

from rich import box
from rich.console import Console
from rich.markup import escape
from rich.table import Table as Grid

from benchmarks import document, results
from benchmarks.rows import Row
from benchmarks.runner import benches, chosen, measure
from benchmarks.tables import Table, tables_of
from deploy.one_thread import use_one_thread

MARKS = {"met": "[green]met[/]", "missed": "[red]missed[/]"}


def main() -> int:
    """Run what was asked for; exit status 1 when a target is missed."""
    options = _options()
    use_one_thread()  # in the children that measure, as the command does and the launcher
    rows: list[Row] = []
    for name in chosen(options.only):
        print(f"{name} ...", file=sys.stderr, flush=True)
        measured = measure(name, options.quick)
        results.replace(name, measured)
        rows += measured
        for table in tables_of(measured):
            show(table)
    if not options.quick:
        document.write()
    return 1 if any(row["met"] is False for row in rows) else 0


def show(table: Table) -> None:
    """Print a table."""
    grid = Grid(
        *map(escape, table.header),
        title=escape(table.title) or None,
        title_justify="left",
        box=box.SIMPLE,
    )
    for line in table.lines:
        marked = [MARKS.get(text, escape(text)) for text in line]
        grid.add_row(*marked)
    Console(width=None if sys.stdout.isatty() else 150).print(grid)


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="shorter runs, rougher figures")
    parser.add_argument(
        "--only",
        action="append",
        metavar="NAME",
        help=f"those whose names begin so; repeatable: {', '.join(benches())}",
    )
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
