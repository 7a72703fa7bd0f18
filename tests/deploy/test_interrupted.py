"""Ctrl-C while the command is still being loaded."""

import subprocess
import sys

import pytest

# Ctrl-C as soon as a module is looked for, then the command as its entry point starts it
PROGRAM = """
import importlib.abc, signal, sys

signal.signal(signal.SIGINT, signal.default_int_handler)  # jobs in the background ignore it

class Interrupting(importlib.abc.MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        if name == {module!r}:
            signal.raise_signal(signal.SIGINT)

sys.meta_path.insert(0, Interrupting())
sys.argv = ["wrenchbus", "list"]
from deploy.main import main
main()
"""


@pytest.mark.parametrize("module", ["deploy.completion", "typer", "deploy.cli", "bus", "zenoh"])
def test_ctrl_c_while_modules_are_loaded_ends_quietly(module):
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(module=module)], capture_output=True, timeout=60.0
    )
    assert (done.returncode, done.stdout, done.stderr) == (130, b"", b"")
