"""Runs the benchmarks, prints a table, writes ``benchmarks/results.json``."""

import argparse
import json
import sys
from importlib import import_module
from pathlib import Path
from pkgutil import iter_modules
from typing import Any

from rich.console import Console
from rich.table import Table

import benchmarks
from benchmarks.load import Load

RESULTS = Path(__file__).parent / "results.json"
KEYS = ("name", "value", "unit", "peer", "ratio", "target", "met", "load")


def main() -> int:
    """Run what was asked for; exit status 1 when a target is missed."""
    options = _options()
    rows: list[dict[str, Any]] = []
    for name in options.only or benches():
        print(f"{name} ...", file=sys.stderr, flush=True)
        rows += measure(name, options.quick)
    RESULTS.write_text(json.dumps(rows, indent=1) + "\n")
    show(rows)
    return 1 if any(row["met"] is False for row in rows) else 0


def benches() -> list[str]:
    """Return the names of the benchmarks: modules ``bench_<name>`` of this package."""
    modules = (module.name for module in iter_modules(benchmarks.__path__))
    return [name.removeprefix("bench_") for name in modules if name.startswith("bench_")]


def measure(name: str, quick: bool) -> list[dict[str, Any]]:
    """Run one benchmark; every row says how busy the whole machine was meanwhile [cores]."""
    module = import_module(f"benchmarks.bench_{name}")
    with Load() as load:
        rows = module.run(quick)
    blank = dict.fromkeys(KEYS)
    return [{**blank, **row, "load": round(load.cores, 2)} for row in rows]


def show(rows: list[dict[str, Any]]) -> None:
    """Print the figures with targets and what was met."""
    table = Table("figure", "value", "unit", "peer", "ratio", "target", "", "load [cores]")
    for row in rows:
        verdict = {True: "[green]met", False: "[red]missed", None: ""}[row["met"]]
        numbers = [_number(row[key]) for key in ("value", "peer", "ratio", "load")]
        value, peer, ratio, load = numbers
        table.add_row(
            row["name"], value, row["unit"], peer, ratio, row["target"] or "", verdict, load
        )
    Console(width=None if sys.stdout.isatty() else 140).print(table)


def _number(value: float | None) -> str:
    return "" if value is None else f"{value:.4g}"


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="python -m benchmarks", description=__doc__)
    parser.add_argument("--quick", action="store_true", help="shorter runs, rougher figures")
    parser.add_argument("--only", action="append", choices=benches(), help="repeatable")
    return parser.parse_args()


if __name__ == "__main__":
    sys.exit(main())
