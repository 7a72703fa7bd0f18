"""What processes take, sampled over a run, and whether it grows."""

import os
from collections import defaultdict
from dataclasses import asdict, dataclass
from pathlib import Path
from statistics import median
from typing import Any

PAGE = os.sysconf("SC_PAGE_SIZE")
GROWTH = {"memory_mb": (0.10, 4.0), "descriptors": (0.1, 4.0), "threads": (0.1, 2.0)}
ENOUGH = 16  # samples, before anything is said about growth


@dataclass
class Sample:
    """One look at one process."""

    memory_mb: float
    descriptors: float
    threads: float


def sample(pid: int) -> Sample:
    """Look at a process; raise OSError when it is gone."""
    process = Path(f"/proc/{pid}")
    resident = int((process / "statm").read_text().split()[1]) * PAGE / 1e6
    threads = len(os.listdir(process / "task"))
    return Sample(resident, len(os.listdir(process / "fd")), threads)


class Gauges:
    """Samples of processes by name; a restarted process begins anew."""

    def __init__(self) -> None:
        self._samples: dict[tuple[str, int], list[Sample]] = defaultdict(list)

    def look(self, name: str, pid: int) -> None:
        """Take one sample."""
        try:
            self._samples[name, pid].append(sample(pid))
        except OSError:
            pass

    def report(self) -> list[dict[str, Any]]:
        """Return first and last quarters' medians of every process that lived long enough."""
        return [
            {"name": name, "samples": len(samples)} | _quarters(samples)
            for (name, _), samples in self._samples.items()
            if len(samples) >= ENOUGH
        ]

    def complaints(self) -> list[str]:
        """Return what has grown."""
        return [
            f"{entry['name']}: {what} grew from {entry[what][0]:g} to {entry[what][1]:g}"
            for entry in self.report()
            for what, (share, more) in GROWTH.items()
            if entry[what][1] > entry[what][0] * (1.0 + share) + more
        ]


def _quarters(samples: list[Sample]) -> dict[str, tuple[float, float]]:
    """The start-up is left out: the second quarter's median, and the last one's."""
    quarter = len(samples) // 4
    early, late = samples[quarter : 2 * quarter], samples[-quarter:]
    return {
        key: tuple(round(median(asdict(s)[key] for s in part), 1) for part in (early, late))
        for key in asdict(samples[0])
    }  # type: ignore[return-value]
