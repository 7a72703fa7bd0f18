"""``param``, ``log``, ``clock``, ``terminate``, ``down``, ``connect``: asked of services."""

import threading
from pathlib import Path

import pytest

from bus import Node
from bus.clock import ClockServer
from bus.testing import eventually
from deploy.main import run
from tests.bus.messages import Number

OUT, IN = "/toy/out:o", "/toy/in:i"


def test_param_lists_gets_and_sets(verb):
    [listed] = verb("param", "list", "toy", "--json").documents
    assert listed["rate"] == 200.0 and listed["output"] == OUT
    assert verb("param", "get", "toy", "rate") == (0, "200.0\n", "")
    assert verb("param", "set", "toy", "fail", "later").out == '"later"\n'
    assert verb("param", "set", "toy", "fail", "").status == 0


def test_param_resets_to_the_configuration_and_saves_what_was_changed(verb):
    verb("param", "set", "toy", "factor", "5")
    [saved] = verb("param", "save", "toy", "--json").documents
    assert "factor: 5" in Path(saved["file"]).read_text()
    assert verb("param", "reset", "toy", "factor").status == 0
    assert float(verb("param", "get", "toy", "factor").out) != 5.0


def test_param_takes_a_negative_number_for_a_value(verb):
    result = verb("param", "set", "toy", "factor", "-1")
    assert result.status == 1 and "factor: Input should be greater than 0" in result.err


@pytest.mark.parametrize("words", [("get", "toy"), ("set", "toy", "rate"), ("list", "toy", "rate")])
def test_param_with_too_few_or_too_many_words_says_what_it_expects(verb, words):
    result = verb("param", *words)
    assert result.status == 2 and f"expected param {words[0]} SERVICE" in result.err


def test_log_shows_what_a_service_has_logged(verb, toy_bus):
    with Node("vandal", connect=toy_bus, signals=False) as node:
        rubbish = node.session.declare_publisher("toy/in:i")

        def logged():
            rubbish.put(b"rubbish")
            return verb("log", "toy", "--json", "-n", "1").documents

        [record] = eventually(logged)
    assert record["service"] == "toy" and record["level"] == "warning"
    assert "refused" in record["text"] and record["time_ns"] > 0
    assert "WARNING toy bus.input: /toy/in:i: message refused" in verb("log").out
    assert verb("log", "toy", "--level", "error").out == ""


def test_log_sets_the_level_of_a_service(verb):
    result = verb("log", "toy", "--set-level", "debug")
    assert result == (0, "toy logs debug and above\n", "")
    assert verb("log", "toy", "--set-level", "info").status == 0
    assert verb("log", "--set-level", "info").status == 2


def test_clock_shows_time_state_and_rate(verb, toy_bus):
    with Node("plant", connect=toy_bus, signals=False) as node:
        server = ClockServer(node, "/plant/clock:o")
        node.ready()
        server.update(2_500_000_000, "paused")

        def work():
            while node.running:
                node.wait(0.02)

        plant = threading.Thread(target=work)
        plant.start()
        [row] = verb("clock", "--json").documents[0]
        node.stop()
        plant.join()
    assert row == {"port": "/plant/clock:o", "time": 2_500_000_000, "state": "paused", "rate": 0.0}


def test_without_a_clock_that_is_said(verb):
    result = verb("clock")
    assert result.status == 1 and "nothing is simulated" in result.err
    assert "no" in verb("clock", "pause", "--robot", "icub").err


def test_connect_and_disconnect_change_who_reads_whom(verb, toy_bus):
    with Node("other", connect=toy_bus, signals=False) as node:
        node.output("/other/out:o", Number)
        node.ready()
        [result] = verb("connect", "/other/out:o", IN, "--json").documents
        assert result == {"sink": IN, "sources": ["/test/out:o", "/other/out:o"]}
        assert verb("wait", "/other/out:o", IN, "--timeout", "30").status == 0
        assert verb("disconnect", "/other/out:o", IN).out == f"{IN} reads /test/out:o\n"
        assert verb("disconnect", "/other/out:o", IN).status == 1


def test_a_wish_is_forgotten_and_the_present_connection_stays(verb):
    verb("connect", "/later/out:o", IN, "--persist")
    forget = ("disconnect", "/later/out:o", IN, "--forget")
    [told] = verb(*forget, "--json").documents
    assert told == {"sink": IN, "sources": ["/test/out:o", "/later/out:o"]}
    assert verb("disconnect", "/later/out:o", IN).status == 0
    assert verb(*forget).out == f"forgotten; at present {IN} reads /test/out:o\n"
    assert verb(*forget, "--persist").status == 2


def test_connect_tells_near_names_and_types_that_differ(verb):
    result = verb("connect", "/toy/uot:o", IN)
    assert result.status == 2 and f"did you mean {OUT}" in result.err
    assert "Number/1" in verb("connect", OUT, "/toy/big:i").err
    result = verb("connect", IN, OUT, "--persist")
    assert result.status == 2 and "the name of an output port ends in :o" in result.err


def test_connections_tell_what_waits_and_what_is_kept_apart(verb):
    for action in ("connect", "disconnect"):
        assert verb(action, f"/later/{action}:o", IN, "--persist").status == 0
    states = {row["source"]: row["state"] for row in verb("connections", "--json").documents[0]}
    assert states["/later/connect:o"] == "waiting" and states["/later/disconnect:o"] == "apart"
    for action in ("connect", "disconnect"):
        verb("disconnect", f"/later/{action}:o", IN, "--forget")
    verb("disconnect", "/later/connect:o", IN)


def test_terminate_ends_a_service_and_returns_when_it_has_gone(hub, start, capsys):
    process = start("tests.bus.toys", "--name", "mortal", "--set", "output=/mortal/out:o")
    assert run(["terminate", "mortal", "--connect", hub]) == 0
    assert "has ended" in capsys.readouterr().out
    assert process.ended() == 0


@pytest.mark.parametrize("name", ["/toy/out:o", "nobody"])
def test_only_a_service_is_terminated(verb, name):
    result = verb("terminate", name)
    assert result.status == 2 and f"no service {name}" in result.err and "toy" in result.err


def test_down_without_a_launcher_says_so(verb):
    result = verb("down")
    assert result.status == 1 and "no launcher on this bus" in result.err
