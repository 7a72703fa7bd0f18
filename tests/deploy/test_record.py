"""``wrenchbus record`` and ``log repair``, against a small bus without a robot."""

import json
import os
import re
import signal

import pytest

from bus import Node
from bus.recording import Recording
from bus.testing import Process, eventually, running_hub, wait_for_service
from deploy.main import run

PORT = "/beacon/light:o"


@pytest.fixture(scope="module")
def bus():
    """Endpoint of a bus with a beacon on it."""
    with running_hub() as endpoint:
        beacon = Process("tests.deploy.beacon", "--connect", endpoint)
        try:
            with Node("watcher", connect=endpoint, signals=False) as watcher:
                wait_for_service(watcher, "beacon", timeout=60.0)
            yield endpoint
        finally:
            beacon.clean_up()


def test_a_recording_of_some_seconds_is_summed_up_port_by_port(bus, tmp_path, capsys):
    path = tmp_path / "a.mcap"
    status = run(["record", PORT, "-o", str(path), "--seconds", "1.5", "--connect", bus])
    out = capsys.readouterr().out
    assert status == 0
    assert PORT in out and f"{path}: " in out and re.search(r" \d lost", out)
    assert Recording(path).ports[PORT].count > 0


def test_json_tells_the_same_and_an_existing_file_needs_force(bus, tmp_path, capsys):
    path = tmp_path / "a.mcap"
    command = ["record", PORT, "-o", str(path), "--seconds", "1", "--json", "--connect", bus]
    assert run(command) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["file"] == str(path) and told["ports"][PORT]["lost"] == told["lost"] < 10
    assert told["size"] == path.stat().st_size and told["messages"] > 0
    assert run(command) == 2 and "--force replaces it" in capsys.readouterr().err
    assert run([*command, "--force"]) == 0


def test_unknown_ports_are_refused_with_near_names(bus, tmp_path, capsys):
    path = tmp_path / "a.mcap"
    assert run(["record", "/beacon/lite:o", "-o", str(path), "--connect", bus]) == 2
    assert "did you mean /beacon/light:o" in capsys.readouterr().err
    assert not path.exists()


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT])
def test_a_signal_closes_the_file(bus, launch, tmp_path, number):
    path = tmp_path / "a.mcap"
    command = launch("record", "-o", str(path), "--connect", bus)
    eventually(lambda: path.exists() and path.stat().st_size > 2000, what="something recorded")
    os.kill(command.popen.pid, number)
    assert command.end() == 0, command.errors
    assert PORT in command.output
    assert Recording(path).ports[PORT].count > 0


def test_a_cut_file_is_repaired_and_what_was_given_up_is_told(bus, tmp_path, capsys):
    path, cut, new = (tmp_path / f"{name}.mcap" for name in ("a", "cut", "new"))
    run(["record", PORT, "-o", str(path), "--seconds", "2.5", "--connect", bus])
    raw = path.read_bytes()
    cut.write_bytes(raw[: len(raw) - 3000])
    capsys.readouterr()
    assert run(["log", "repair", str(cut), "-o", str(new), "--json"]) == 0
    told = json.loads(capsys.readouterr().out)
    assert told["messages"] == Recording(new).ports[PORT].count > 0
    assert told["given_up"][-1]["end"] == len(raw) - 3000
