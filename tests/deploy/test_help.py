"""The command's help and its answers to mistakes."""

import pytest

from deploy.cli import app
from deploy.main import run

VERBS = [command.name or "" for command in app.registered_commands] + ["log"]
SAY_IT_BY_STATUS = {"demo", "up", "down", "run", "terminate", "exists", "wait", "write"}
SHOW_IT = {"play", "replay", "graph"}


@pytest.mark.parametrize("verb", VERBS)
def test_help_of_every_verb_ends_with_an_example(verb, capsys):
    assert run([verb, "--help"]) == 0
    assert f"Example: wrenchbus {verb}" in capsys.readouterr().out


@pytest.mark.parametrize("verb", sorted(set(VERBS) - SAY_IT_BY_STATUS - SHOW_IT))
def test_every_verb_that_prints_data_prints_json_too(verb, capsys):
    words = ["log", "services"] if verb == "log" else [verb]
    assert run([*words, "--help"]) == 0
    assert "--json" in capsys.readouterr().out


def test_help_names_every_verb(capsys):
    assert run(["--help"]) == 0
    shown = capsys.readouterr().out
    assert all(f"  {verb} " in shown for verb in VERBS)


def test_without_a_verb_the_help_is_shown_and_the_status_is_2(capsys):
    assert run([]) == 2
    shown = capsys.readouterr()
    assert shown.out == "" and "\n  read " in shown.err and "\n  push " in shown.err


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["raed", "/x:o"], "'read'"),
        (["push", "chest"], "--force"),
        (["push", "chest", "--force", "1,2"], "expected X,Y,Z"),
        (["push", "chest", "--force", "1,nan,0"], "finite"),
        (["push", "chest", "--force", "1,2,3", "--frame", "wrold"], "wrold"),
        (["up", "no_such.yaml"], "no application file no_such.yaml"),
        (["up", "dmo"], "did you mean demo?"),
        (["run", "torque_obsever"], "did you mean torque_observer?"),
        (["demo", "--robot", "icup"], "did you mean 'icub'?"),
        (["demo", "--profile", "ideel"], "did you mean 'ideal'?"),
        (["demo", "--scenario", "dmo"], "did you mean 'demo'?"),
        (["demo", "--base", "afloat"], "afloat"),
    ],
)
def test_wrong_usage_is_one_line_and_status_2(arguments, expected, capsys):
    assert run(arguments) == 2
    shown = capsys.readouterr()
    assert shown.out == ""
    assert expected in shown.err
    assert shown.err.count("\n") == 1


def test_without_a_bus_a_verb_says_how_to_start_one(runtime_directory, capsys):
    assert run(["list"]) == 1
    shown = capsys.readouterr().err
    assert "no bus is running" in shown and "wrenchbus demo" in shown
    assert shown.count("\n") == 1


def test_an_endpoint_without_a_hub_is_one_line_and_status_1(runtime_directory, capsys):
    assert run(["list", "-e", "tcp/127.0.0.1:9"]) == 1
    assert capsys.readouterr().err == "wrenchbus: no hub answers at tcp/127.0.0.1:9\n"
