"""How threads run: ours beside others, and Zenoh's in Python."""

import ctypes
import os
from threading import get_ident

_adopted: set[int] = set()  # a thread that gets the number of an ended one is only slower


def be_patient() -> None:
    """Let the calling thread wait for others to pause, instead of cutting them in pieces.

    For loops that nobody waits for: one that is interrupted finds its caches cold afterwards.
    """
    if hasattr(os, "SCHED_BATCH") and os.sched_getscheduler(0) == os.SCHED_OTHER:
        os.sched_setscheduler(0, os.SCHED_BATCH, os.sched_param(0))


def adopt() -> None:
    """Keep what Python knows of the calling thread, which is Zenoh's and delivers messages.

    It would be made anew for every callback, which costs 20 us and more.
    """
    if (thread := get_ident()) not in _adopted:
        _adopted.add(thread)
        ctypes.pythonapi.PyGILState_Ensure()  # never released
