"""Runs a module as ``python -m`` would, bound to the life of its parent.

Usage: ``python -m bus.child PARENT_PID PRIORITY MODULE [ARGUMENT ...]``; the priority is a
niceness, or ``realtime``.
"""

import ctypes
import os
import runpy
import signal
import sys
from contextlib import suppress

PR_SET_PDEATHSIG = 1  # <linux/prctl.h>


def die_with(parent: int) -> None:
    """Let the kernel kill this process when its parent ends, however that ends."""
    if sys.platform.startswith("linux"):
        ctypes.CDLL(None).prctl(PR_SET_PDEATHSIG, signal.SIGKILL)
    if os.getppid() != parent:  # it died before the line above took effect
        sys.exit(1)


def take(priority: str) -> None:
    """Take a niceness; or the lowest real-time priority, where the system permits it."""
    if priority != "realtime":
        os.nice(int(priority))
        return
    with suppress(AttributeError, OSError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))


def main() -> None:
    """Bind to the parent, take the priority, become the module."""
    parent, priority, module, *arguments = sys.argv[1:]
    die_with(int(parent))
    take(priority)  # before any thread exists: threads inherit it
    sys.argv = [module, *arguments]
    runpy.run_module(module, run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
