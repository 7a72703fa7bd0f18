"""How busy the machine was, and who was busy."""

import time

import psutil


class Load:
    """Cores in use, averaged over a ``with`` block; idle and waiting for disks is not use."""

    def __enter__(self) -> "Load":
        self._start = _busy_seconds(), time.monotonic()
        self.cores = 0.0
        return self

    def __exit__(self, *_: object) -> None:
        busy, start = self._start
        self.cores = (_busy_seconds() - busy) / max(time.monotonic() - start, 1e-9)


def processor_seconds(pid: int) -> float:
    """Return the processor time of a process and its threads so far [s]."""
    times = psutil.Process(pid).cpu_times()
    return times.user + times.system


def _busy_seconds() -> float:
    times = psutil.cpu_times()
    return sum(times) - times.idle - getattr(times, "iowait", 0.0) - getattr(times, "guest", 0.0)
