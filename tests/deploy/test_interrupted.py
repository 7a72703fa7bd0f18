"""Ctrl-C while the command is still being loaded, and while a verb waits."""

import subprocess
import sys

import pytest

from bus import Node
from deploy.verbs.service import _until
from tests.bus.messages import Number

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


def interrupted(node, *_: object, **__: object) -> None:
    """In the place of what waits: Ctrl-C comes meanwhile."""
    node.stop()


QUIETLY = (130, "", "")


def test_ctrl_c_while_a_sample_is_awaited_is_no_missing_message(verb, toy_bus, monkeypatch):
    with Node("mute", connect=toy_bus, signals=False) as mute:
        mute.output("/mute/out:o", Number)
        mute.ready()
        monkeypatch.setattr(Node, "wait", interrupted)
        assert verb("sample", "/mute/out:o") == QUIETLY


@pytest.mark.parametrize("words", [("exists", "/none:o"), ("read", "/none:o"), ("ping", "nobody")])
def test_ctrl_c_while_names_are_heard_does_not_say_that_one_is_missing(verb, words, monkeypatch):
    monkeypatch.setattr("bus.introspection.hear_all", interrupted)
    monkeypatch.setattr("deploy.discovery.hear_all", interrupted)
    assert verb(*words) == QUIETLY


def test_ctrl_c_ends_a_wait_as_it_ends_other_verbs(verb, monkeypatch):
    monkeypatch.setattr("deploy.verbs.presence._found", interrupted)
    assert verb("wait", "/none:o") == QUIETLY


def test_ctrl_c_while_a_service_ends_does_not_say_that_it_stays():
    class Ended:
        running = False

    with pytest.raises(KeyboardInterrupt):
        _until(Ended(), lambda: False, 5.0, "the toy")  # type: ignore[arg-type]
