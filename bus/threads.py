"""Zenoh's threads, of which Python and the scheduler should know more."""

import ctypes
import os
import threading
from collections.abc import Iterator
from contextlib import contextmanager

_adopted = threading.local()
_CAN_CHOOSE = hasattr(os, "SCHED_BATCH")


def be_patient() -> None:
    """Let the calling thread wait for others to pause; for loops that others do not wait for."""
    if _CAN_CHOOSE and os.sched_getscheduler(0) == os.SCHED_OTHER:
        _choose(os.SCHED_BATCH)


@contextmanager
def patient() -> Iterator[None]:
    """Start threads that wait for the running one to pause, instead of cutting it in pieces.

    Zenoh's threads wake thousands of times per second. A loop that is interrupted by each
    finds its caches cold afterwards.
    """
    policy = os.sched_getscheduler(0) if _CAN_CHOOSE else None
    if policy is None or policy != os.SCHED_OTHER:
        yield
        return
    _choose(os.SCHED_BATCH)
    try:
        yield
    finally:
        _choose(policy)


def adopt() -> None:
    """Make the calling thread of Zenoh's, which delivers messages, as good as one of Python's.

    What Python knows of it would otherwise be made anew for every callback, which costs
    20 us and more; and the loop that it wakes has waited for it.
    """
    if not hasattr(_adopted, "state"):
        _adopted.state = ctypes.pythonapi.PyGILState_Ensure()  # never released
        ours = threading.current_thread() is threading.main_thread()
        if _CAN_CHOOSE and not ours and os.sched_getscheduler(0) == os.SCHED_BATCH:
            _choose(os.SCHED_OTHER)


def _choose(policy: int) -> None:
    os.sched_setscheduler(0, policy, os.sched_param(0))
