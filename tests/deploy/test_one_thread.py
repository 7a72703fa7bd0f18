"""Linear algebra of the command runs in one thread."""

import os
import subprocess
import sys

import pytest

from deploy.one_thread import ONE_THREAD, use_one_thread


def test_one_thread_unless_the_user_said_otherwise(monkeypatch: pytest.MonkeyPatch) -> None:
    for name in ONE_THREAD:
        monkeypatch.setenv(name, "")
        monkeypatch.delenv(name)
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2")
    use_one_thread()
    assert os.environ["OMP_NUM_THREADS"] == "1"
    assert os.environ["OPENBLAS_NUM_THREADS"] == "2"


def test_the_command_says_so_before_numpy_is_loaded() -> None:
    check = "import sys, deploy.main; sys.exit('numpy' in sys.modules)"
    assert subprocess.run([sys.executable, "-c", check]).returncode == 0
