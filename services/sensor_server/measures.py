"""Small measures of the loop: time that passed, ages that were seen."""

import numpy as np


class RunningTime:
    """Seconds that pass while the robot's clock runs; a pause or a jump back adds nothing."""

    def __init__(self) -> None:
        self.seconds = 0.0
        self._last: int | None = None

    def advance(self, reading: int, running: bool = True) -> float:
        """Take the next reading of a clock [ns] and return the time so far [s]."""
        if self._last is not None and running:
            self.seconds += max(0, reading - self._last) * 1e-9
        self._last = reading
        return self.seconds


class Ages:
    """Ages of the last messages of a stream.

    Args:
        window: Number of messages that are remembered.
    """

    def __init__(self, window: int):
        self._ages = np.zeros(window)
        self._count = 0

    def add(self, age: float) -> None:
        """Add the age of one message [s]."""
        self._ages[self._count % len(self._ages)] = age
        self._count += 1

    def summary(self) -> dict[str, float | int]:
        """Return how many messages came, and quantiles of the last ones [s]."""
        ages = self._ages[: self._count]
        if not len(ages):
            return {"count": 0, "window": 0}
        p50, p99 = np.percentile(ages, [50.0, 99.0]).tolist()
        summary = {"p50": p50, "p99": p99, "max": float(ages.max())}
        return {"count": self._count, "window": len(ages), **summary}

    def clear(self) -> None:
        """Start again."""
        self._count = 0
