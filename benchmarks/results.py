"""The figures of all benchmarks: ``results.json``, where each keeps its last ones."""

import json
from pathlib import Path

from benchmarks.rows import Row

RESULTS = Path(__file__).parent / "results.json"


def replace(bench: str, rows: list[Row]) -> list[Row]:
    """Store a benchmark's figures in place of its former ones; return those of all."""
    others = [old for old in read() if old.get("bench") not in (bench, None)]
    everything = others + [figure | {"bench": bench} for figure in rows]
    RESULTS.write_text(json.dumps(everything, indent=1) + "\n")
    return everything


def read() -> list[Row]:
    """Return what is stored, nothing when there is nothing to be read."""
    try:
        return json.loads(RESULTS.read_text())
    except (OSError, ValueError):
        return []
