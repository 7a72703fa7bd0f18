"""One thread for linear algebra: matrices are small, and threads that wait for one spin."""

import os

ONE_THREAD = dict.fromkeys(("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS"), "1")


def use_one_thread() -> None:
    """Settle it for this process and its children, unless the user did; before NumPy loads."""
    for name, count in ONE_THREAD.items():
        os.environ.setdefault(name, count)
