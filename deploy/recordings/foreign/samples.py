"""Rows of numbers with their times, as they are read line by line."""

import math
from pathlib import Path
from typing import Any

import numpy as np

from deploy.recordings.foreign.problems import Problems

LATEST = 1 << 62  # ns; later is no time


class Samples:
    """Takes the lines of one stream and keeps those that are sound.

    Args:
        file: For the report.
        width: Numbers that a line must have at least; further ones are not kept.
        problems: Where the others are counted.
    """

    def __init__(self, file: Path, width: int, problems: Problems):
        self._file, self._width, self._problems = file, width, problems
        self._lines: list[int] = []
        self._times: list[int] = []
        self._rows: list[list[float]] = []

    def add(self, line: int, time: float, numbers: list[Any]) -> None:
        """Take one line; ``time`` [s] or, if an int, [ns]."""
        kind, detail = self._check(time, numbers)
        if kind:
            self._problems.line(self._file, line, kind, detail)
            return
        self._lines.append(line)
        self._times.append(_nanoseconds(time))
        self._rows.append([float(number) for number in numbers[: self._width]])

    def _check(self, time: float, numbers: list[Any]) -> tuple[str, str]:
        if not 0 <= (time if isinstance(time, int) else time * 1e9) < LATEST:
            return "no time stamp", repr(time)
        if len(numbers) < self._width:
            return f"expected {self._width} numbers or more", f"got {len(numbers)}"
        for number in numbers[: self._width]:
            if type(number) not in (int, float) or not math.isfinite(number):
                return "not a finite number", repr(number)
        return "", ""

    def arrays(self) -> tuple[np.ndarray, np.ndarray]:
        """Return times (T,) [ns], strictly rising, and values (T, width)."""
        times = np.array(self._times, dtype=np.int64)
        values = np.array(self._rows, dtype=float).reshape(-1, self._width)
        kept = rising(times)
        for index in np.flatnonzero(~kept).tolist():
            detail = f"{times[index] * 1e-9:.6f} s"
            self._problems.line(self._file, self._lines[index], "a time stamp out of order", detail)
        return times[kept], values[kept]


def rising(times: np.ndarray) -> np.ndarray:
    """Return which times to keep so that they rise strictly, (T,) booleans.

    Either those that exceed all before, or those that are exceeded by all after, whichever
    are more: a single wrong stamp, too high or too low, costs no others.
    """
    if not len(times):
        return np.zeros(0, dtype=bool)
    forward, backward = np.ones(len(times), dtype=bool), np.ones(len(times), dtype=bool)
    forward[1:] = times[1:] > np.maximum.accumulate(times)[:-1]
    backward[:-1] = times[:-1] < np.minimum.accumulate(times[::-1])[::-1][1:]
    return forward if forward.sum() >= backward.sum() else backward


def _nanoseconds(time: float) -> int:
    return time if isinstance(time, int) else round(time * 1e9)
