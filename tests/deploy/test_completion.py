"""What the shell suggests."""

import subprocess
import sys

import pytest

from deploy import main


@pytest.fixture
def complete(monkeypatch, capsys):
    """Return ``complete(*words)``: what bash is told for the last word, split as bash does it."""

    def completed(*words):
        monkeypatch.setenv("_WRENCHBUS_COMPLETE", "complete_bash")
        monkeypatch.setenv("COMP_WORDS", "\n".join(["wrenchbus", *words]))
        monkeypatch.setenv("COMP_CWORD", str(len(words)))
        monkeypatch.setattr("sys.argv", ["wrenchbus"])
        monkeypatch.setattr("sys.__stdout__", sys.stdout)
        with pytest.raises(SystemExit):
            main.main()
        shown = capsys.readouterr()
        assert shown.err == ""
        return shown.out.split()

    return completed


def test_ports_of_the_running_bus_are_suggested(complete, toy_bus, monkeypatch):
    monkeypatch.setenv("WRENCHBUS_CONNECT", toy_bus)
    assert complete("read", "/toy/o") == ["/toy/out:o"]
    assert {"/toy/in:i", "/toy/out:o"} <= set(complete("info", "/toy/"))
    assert complete("connect", "/toy/out", ":", "o", "/toy/b") == ["/toy/big:i"]


def test_after_a_colon_bash_gets_what_follows_it(complete, toy_bus, monkeypatch):
    monkeypatch.setenv("WRENCHBUS_CONNECT", toy_bus)
    assert complete("where", "/toy/rpc", ":") == ["i"]
    assert complete("where", "/toy/rpc", ":", "i") == ["i"]


def test_services_and_verbs_are_suggested(complete, toy_bus, monkeypatch):
    monkeypatch.setenv("WRENCHBUS_CONNECT", toy_bus)
    assert complete("terminate", "to") == ["toy"]
    assert complete("ping", "h") == ["hub"]
    assert complete("lat") == ["latency-test"]


def test_without_a_bus_nothing_is_suggested_and_nothing_said(complete, runtime_directory):
    assert complete("read", "/toy/o") == []


def test_a_hub_that_does_not_answer_holds_the_prompt_up_only_shortly(complete, monkeypatch):
    monkeypatch.setenv("WRENCHBUS_CONNECT", "tcp/127.0.0.1:9")
    assert complete("read", "/toy/o") == []


def test_the_shell_gets_its_script():
    command = [sys.executable, "-m", "deploy.main", "--show-completion", "bash"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60)
    assert done.returncode == 0 and "_WRENCHBUS_COMPLETE=complete_bash" in done.stdout
