"""Runs a module as ``python -m`` would, bound to the life of its parent.

It finds the packages that its parent has. The working directory comes last: a folder there
that is called ``bus`` or ``services`` is not taken for ours.
"""

import ctypes
import os
import runpy
import signal
import sys
from contextlib import suppress
from pathlib import Path

PR_SET_PDEATHSIG = 1  # <linux/prctl.h>
ROOT = Path(__file__).resolve().parents[1]
UNBOUND = "0"  # instead of a parent's number


def command(module: str, *arguments: str, priority: str = "0", bound: bool = True) -> list[str]:
    """Return the command that runs a module with the packages of this process.

    Args:
        module, arguments: As of ``python -m``.
        priority: A niceness, or ``realtime``.
        bound: Whether it dies with this process.
    """
    parent = str(os.getpid()) if bound else UNBOUND
    return [sys.executable, "-P", __file__, parent, priority, module, *arguments]


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
    if parent != UNBOUND:
        die_with(int(parent))
    take(priority)  # before any thread exists: threads inherit it
    sys.path += [str(ROOT), os.getcwd()]
    sys.argv = [module, *arguments]
    runpy.run_module(module, run_name="__main__", alter_sys=True)


if __name__ == "__main__":
    main()
