"""What processes of this machine take, from the kernel's own tables."""

import os
import time
from pathlib import Path
from typing import NamedTuple

PROC = Path("/proc")


class Usage(NamedTuple):
    """One look at a process."""

    at: float  # monotonic [s]
    cpu: float  # seconds of a processor since its start
    memory: int  # resident [bytes]


def usage(pid: int) -> Usage | None:
    """Return what a process has taken; None when it is not here."""
    try:
        fields = (PROC / str(pid) / "stat").read_text().rpartition(")")[2].split()
        user, system, pages = (int(fields[number - 3]) for number in (14, 15, 24))  # see proc(5)
    except (OSError, ValueError, IndexError):
        return None
    cpu = (user + system) / os.sysconf("SC_CLK_TCK")
    return Usage(time.monotonic(), cpu, pages * os.sysconf("SC_PAGE_SIZE"))
