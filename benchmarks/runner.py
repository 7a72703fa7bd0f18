"""Which benchmarks there are, and running one."""

import os
import sys
from concurrent.futures import ProcessPoolExecutor
from datetime import datetime
from importlib import import_module
from multiprocessing import get_context
from pkgutil import iter_modules
from typing import Any

import benchmarks
from benchmarks.load import Load
from benchmarks.rows import Row

KEYS = ("name", "value", "unit", "peer", "ratio", "target", "met", "load")


def benches() -> list[str]:
    """Return the names of the benchmarks: modules ``bench_<name>`` of this package."""
    modules = (module.name for module in iter_modules(benchmarks.__path__))
    return [name.removeprefix("bench_") for name in modules if name.startswith("bench_")]


def chosen(wanted: list[str] | None) -> list[str]:
    """Return the benchmarks that begin with a name wanted; long ones only by their full name."""
    names = benches()
    unknown = [word for word in wanted or () if not any(n.startswith(word) for n in names)]
    if unknown:
        sys.exit(f"unknown benchmark {', '.join(unknown)}; there are: {', '.join(names)}")
    return [
        name
        for name in names
        if name in (wanted or ())
        or (name.startswith(tuple(wanted or [""])) and not name.endswith("_long"))
    ]


def measure(name: str, quick: bool) -> list[Row]:
    """Run one benchmark in a process of its own; each row says how busy the machine was [cores]."""
    with Load() as load, ProcessPoolExecutor(1, get_context("spawn")) as pool:
        rows = pool.submit(_run, name, quick).result()
    blank: dict[str, Any] = dict.fromkeys(KEYS)
    about = {"load": round(load.cores, 2), "quick": quick, "nice": os.nice(0)}
    about["measured"] = datetime.now().isoformat(" ", "minutes")
    return [blank | row | about for row in rows]


def _run(name: str, quick: bool) -> list[Row]:
    return import_module(f"benchmarks.bench_{name}").run(quick)
