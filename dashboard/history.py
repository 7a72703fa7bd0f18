"""The last seconds of a vector signal, for a chart."""

import numpy as np

Array = np.ndarray


class History:
    """Ring of samples; those that were not valid are NaN, which a chart leaves out."""

    def __init__(self, length: int, width: int):
        self._times = np.full(length, np.nan)
        self._values = np.full((length, width), np.nan)
        self._next = 0

    def add(self, time: float, values: Array) -> None:
        """Append one sample, (width,), taken at ``time`` [s]; a time that ran back clears."""
        if time < self._times[self._next - 1]:
            self.clear()
        self._times[self._next] = time
        self._values[self._next] = values
        self._next = (self._next + 1) % len(self._times)

    def clear(self) -> None:
        """Forget all samples."""
        self._times[:] = np.nan
        self._values[:] = np.nan
        self._next = 0

    def column(self, index: int) -> tuple[Array, Array]:
        """Return ages, (m,) [s], negative and rising to zero, and one column of values, (m,)."""
        order = np.roll(np.arange(len(self._times)), -self._next)
        order = order[np.isfinite(self._times[order])]
        times = self._times[order]
        ages = times - times[-1] if len(times) else times
        return ages, self._values[order, index]
