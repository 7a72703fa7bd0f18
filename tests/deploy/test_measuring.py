"""``hz``, ``bw``, ``delay``, ``ping``, ``top``, ``sample``, ``read``: what flows."""

import threading
import time
from functools import partial

import numpy as np
import pytest

from bus import Node
from deploy import streams
from tests.bus.messages import Mixed, mixed

OUT, IN = "/toy/out:o", "/toy/in:i"
SIZES = 100, 150  # bytes of the toy's messages, which say why they are invalid


def test_bw_tells_bytes_per_second_and_sizes(verb):
    [row] = verb("bw", OUT, "--seconds", "0.5", "--json").documents
    assert row["received"] > 5
    assert SIZES[0] < row["size_min"] <= row["size_p50"] <= row["size_max"] < SIZES[1]
    assert SIZES[0] < row["bytes_per_s"] / row["hz"] < SIZES[1]


def test_delay_tells_the_age_of_data_at_arrival(verb):
    [row] = verb("delay", OUT, "--seconds", "0.5", "--json").documents
    assert row["received"] > 5
    assert 0.0 < row["sent_p50"] <= row["sent_p99"] <= row["sent_max"] < 10.0
    assert row["acquired_p50"] >= row["sent_p50"]


def test_delay_says_that_clocks_must_agree(verb):
    assert "must agree" in verb("delay", OUT, "--seconds", "0.1").out
    assert "must agree" in verb("delay", "--help").out


@pytest.mark.parametrize(
    ("name", "titles"),
    [
        ("hz", ("hz", "period_p50 [s]", "period_max [s]", "lost", "dropped")),
        ("bw", ("bytes_per_s", "size_p50 [B]", "seconds [s]")),
        ("delay", ("acquired_p99 [s]", "sent_max [s]", "received")),
    ],
)
def test_tables_of_what_flows_have_units(verb, name, titles):
    first = verb(name, OUT, "--seconds", "0.1").out.splitlines()[0]
    assert all(title in first for title in titles)


def test_read_tells_what_it_missed_and_otherwise_nothing(verb, monkeypatch):
    assert verb("read", OUT, "-n", "3").err == ""
    monkeypatch.setattr(streams, "open_port", partial(streams.open_port, depth=1))
    monkeypatch.setattr("deploy.verbs.read._show", lambda *_: time.sleep(0.1))  # a slow terminal
    result = verb("read", OUT, "-n", "4")
    assert result.status == 0
    assert f"messages of {OUT} missed: " in result.err and " dropped, as they came" in result.err


def test_sample_prints_one_message_and_ends(verb):
    [line] = verb("sample", OUT, "--json").documents
    assert line["port"] == OUT and line["data"] == {"value": 0.0}


def test_sample_ends_with_1_when_nothing_comes(verb, toy_bus):
    with Node("mute", connect=toy_bus, signals=False) as node:
        node.output("/mute/out:o", Mixed)
        node.ready()
        result = verb("sample", "/mute/out:o", "--timeout", "0.2")
    assert result == (1, "", "wrenchbus: no message on /mute/out:o within 0.2 s\n")


@pytest.mark.parametrize("name", ["read", "echo"])
def test_read_shows_stamp_and_sequence_only_when_asked(verb, name):
    plain = verb(name, OUT, "-n", "2").out.splitlines()
    assert len(plain) == 5 and plain[0].startswith("INVALID: no")
    assert plain[1:3] == ["  value [m]: 0.0", "---"]
    first = verb(name, OUT, "-n", "1", "--envelope").out.splitlines()[0]
    assert first.startswith("seq ") and " stamp " in first and "(wall)" in first


@pytest.mark.parametrize("name", ["read", "sample", "hz", "bw", "delay"])
def test_only_outputs_are_read(verb, name):
    result = verb(name, IN)
    assert result.status == 2
    assert "is an input, expected an output; it reads /test/out:o" in result.err


def test_a_megabyte_is_read_when_the_port_allows_it(verb, toy_bus):
    picture = mixed(n=65536, k=2, extra=np.ones(65536))
    with Node("camera", connect=toy_bus, signals=False) as node:
        out = node.output("/camera/image:o", Mixed, max_message=2 << 20)
        node.ready()

        def work():
            while node.running:
                node.wait(0.1)
                out.write(picture)

        writer = threading.Thread(target=work)
        writer.start()
        result = verb("sample", "/camera/image:o", "--json", "--timeout", "30")
        node.stop()
        writer.join()
    assert result.status == 0 and len(result.out) > 500_000
    assert len(result.documents[0]["data"]["q"]) == 65536


def test_ping_measures_round_trips_of_a_service_or_of_a_ports_owner(verb):
    for name in ("toy", OUT, "/toy/rpc:i"):
        [row] = verb("ping", name, "-n", "2", "--interval", "0", "--json").documents
        assert row["port"] == "/toy/rpc:i" and row["asked"] == row["answered"] == 2
        assert 0.0 < row["min"] <= row["p50"] <= row["max"]


def test_ping_of_nobody_names_who_is_there(verb):
    result = verb("ping", "tyo")
    assert result.status == 2 and "did you mean toy?" in result.err


def test_top_shows_rates_losses_and_what_processes_take(verb):
    [document] = verb("top", "--json", "--interval", "0.5").documents
    port = next(row for row in document["ports"] if row["port"] == OUT)
    assert port["owner"]["service"] == "toy" and port["hz"] > 10.0
    assert SIZES[0] - 10 < port["bytes_per_s"] / port["hz"] < SIZES[1]
    entry = next(row for row in document["ports"] if row["port"] == IN)
    assert entry["lost"] == entry["dropped"] == entry["refused"] == 0
    toy = next(row for row in document["processes"] if row["service"] == "toy")
    assert toy["ports"] >= 4 and toy["cpu_percent"] > 0.0 and toy["memory_bytes"] > 10**7


def test_top_as_text_has_a_line_per_port_and_process(verb):
    shown = verb("top", "-n", "1", "--interval", "0.1").out
    assert f"\n{OUT} " in shown and "\ntoy " in shown and "\x1b" not in shown
