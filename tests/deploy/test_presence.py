"""``exists``, ``wait``, ``where``: exit statuses that scripts can rely on."""

import threading
import time
from datetime import datetime

import psutil
import pytest

from bus import Node
from bus.testing import eventually, free_port, start_hub
from deploy.main import run
from tests.bus.messages import Number

OUT, IN = "/toy/out:o", "/toy/in:i"


@pytest.mark.parametrize("name", [OUT, IN, "toy", "hub"])
def test_exists_ends_with_0_for_what_is_there_and_says_nothing(verb, name):
    assert verb("exists", name) == (0, "", "")


@pytest.mark.parametrize("name", ["/toy/none:o", "nobody"])
def test_exists_ends_with_1_for_what_is_not_there_soon_and_without_a_word(verb, name):
    start = time.monotonic()
    assert verb("exists", name) == (1, "", "")
    assert time.monotonic() - start < 5.0


def test_exists_with_an_input_tells_whether_that_reads_the_port(verb, toy_bus):
    assert verb("exists", OUT, IN).status == 1
    assert verb("exists", "/test/out:o", IN).status == 1, "it is wired, but nobody writes it"
    with Node("test", connect=toy_bus, signals=False) as node:
        node.output("/test/out:o", Number)
        node.ready()
        assert verb("exists", "/test/out:o", IN).status == 0


def test_wait_ends_with_0_as_soon_as_the_port_is_there(verb, toy_bus):
    statuses = []
    arguments = ["wait", "/late/out:o", "--timeout", "60", "--connect", toy_bus]
    waiter = threading.Thread(target=lambda: statuses.append(run(arguments)))
    waiter.start()
    with Node("late", connect=toy_bus, signals=False) as node:
        eventually(lambda: len(node.session.info.peers_zid()), what="the waiting command")
        assert waiter.is_alive()
        node.output("/late/out:o", Number)
        node.ready()
        waiter.join(30.0)
    assert statuses == [0]


def test_wait_ends_with_1_after_its_timeout_in_one_line(verb):
    result = verb("wait", "/toy/none:o", "--timeout", "0.3")
    assert result.status == 1 and result.out == ""
    assert result.err == "wrenchbus: /toy/none:o is not there after 0.3 s\n"


def test_wait_waits_for_the_bus_itself_too(runtime_directory, capsys):
    assert run(["wait", OUT, "--timeout", "0.5"]) == 1
    shown = capsys.readouterr().err
    assert "after 0.5 s: no bus is running" in shown and shown.count("\n") == 1


def test_wait_waits_for_a_hub_at_a_certain_endpoint_too(monkeypatch, capsys):
    monkeypatch.setattr("deploy.session.HUB_DEADLINE", 0.1)
    endpoint, statuses = f"tcp/127.0.0.1:{free_port()}", []
    arguments = ["wait", "hub", "--timeout", "60", "--connect", endpoint]
    waiter = threading.Thread(target=lambda: statuses.append(run(arguments)))
    waiter.start()
    waiter.join(0.5)  # several looks in vain; at once when it gives up
    assert waiter.is_alive()
    _, hub = start_hub(endpoint)
    try:
        waiter.join(60.0)
        assert statuses == [0]
    finally:
        hub.clean_up()
    assert run([*arguments[:3], "0.1", *arguments[4:]]) == 1
    assert f"hub is not there after 0.1 s: no hub answers at {endpoint}" in capsys.readouterr().err


def test_where_tells_service_host_process_and_since_when(verb):
    [row] = verb("where", OUT, "--json").documents
    assert row["port"] == OUT and row["service"] == "toy" and row["pid"] > 0 and row["host"]
    since = datetime.fromisoformat(row["since"])
    assert since.tzinfo is not None
    assert psutil.Process().create_time() < since.timestamp() < time.time()
    assert abs(since.timestamp() - 1e-9 * row["since_ns"]) < 0.002


def test_where_suggests_near_names(verb):
    result = verb("where", "/toy/outt:o")
    assert result.status == 2 and f"did you mean {OUT}" in result.err
