"""The same with 10^7 messages.

Runs when it is asked for by its name: ``make bench ARGS="--only bus_memory_long"``, 17 minutes.
"""

from benchmarks.bench_bus_memory import growth
from benchmarks.rows import Row

MESSAGES, QUICK = 10_000_000, 1_000_000
FLAT = 0.1  # bytes per message: 1 MB in all


def run(quick: bool = False) -> list[Row]:
    """Return the memory of the three at the end, and how it grew."""
    return growth(QUICK if quick else MESSAGES, FLAT)
