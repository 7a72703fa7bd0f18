"""The verbs that work on any port, against a small bus without a robot."""

import json
import subprocess
import sys

import pytest

from bus import Node
from bus.testing import Process, running_hub, wait_for_service
from deploy.main import run
from tests.deploy.beacon import LIGHT

PORT = "/beacon/light:o"
WITHOUT_ROBOT = """
import sys
from deploy.main import run
_, bus, out, sink = sys.argv
for words in (
    "list", "top -n 1", "connections", "status", "log", "param list toy", "rpc toy help",
    "ping toy -n 1", f"info {out}", f"where {out}", f"exists {out}", f"wait {out}",
    f"read {out} -n 1", f"echo {out} -n 1", f"sample {out}", f"hz {out} --seconds 0.1",
    f"bw {out} --seconds 0.1", f"delay {out} --seconds 0.1", f"write {sink} value=0",
    f"connect {out} {sink} --persist", f"disconnect {out} {sink}",
    f"disconnect {out} {sink} --forget", "latency-test --seconds 0.1",
):
    verb, *rest = words.split()
    assert run([verb, "--connect", bus, *rest]) == 0, words
print([m for m in ("robot_model", "pinocchio", "viser", "robot_sim") if m in sys.modules])
"""


@pytest.fixture(scope="module")
def bus():
    """Endpoint of a bus with a beacon on it."""
    with running_hub() as endpoint:
        beacon = Process("tests.deploy.beacon", "--connect", endpoint)
        try:
            with Node("watcher", connect=endpoint, signals=False) as watcher:
                wait_for_service(watcher, "beacon", timeout=60.0)
            yield endpoint
            assert beacon.stop() == 0
        finally:
            beacon.clean_up()


@pytest.fixture
def ask(bus, capsys):
    """Return ``ask(*arguments)``: status and JSON lines of a verb."""

    def asked(*arguments):
        status = run([*arguments, "--json", "--connect", bus])
        return status, [json.loads(line) for line in capsys.readouterr().out.splitlines()]

    return asked


def test_list_tells_name_type_direction_owner_rate_and_sources(ask):
    status, [ports] = ask("list")
    port = next(port for port in ports if port["name"] == PORT)
    assert status == 0
    assert port["type"] == "Light/1" and port["direction"] == "output"
    assert port["owner"]["service"] == "beacon" and port["owner"]["pid"] > 0
    assert port["nominal_hz"] == 100.0 and port["sources"] == []


def test_info_tells_fields_units_and_statistics(ask):
    status, [port] = ask("info", PORT)
    fields = {field["name"]: field for field in port["fields"]}
    assert status == 0 and port["name"] == PORT
    assert fields["point"]["unit"] == "m" and fields["point"]["frame"] == "world"
    assert port["statistics"]["written"] >= 0


def test_info_as_text_says_what_a_message_is(bus, capsys):
    assert run(["info", PORT, "--connect", bus]) == 0
    shown = capsys.readouterr().out
    assert "\nWhere a beacon shines.\n" in shown and "nominal rate: 100 Hz; of late " in shown


def test_info_as_text_says_why_an_input_is_not_fresh(verb):
    assert "\nstate: nobody writes /test/big:o\n" in verb("info", "/toy/big:i").out


def test_read_prints_one_line_per_message_with_all_fields(ask):
    status, lines = ask("read", PORT, "-n", "3")
    assert status == 0 and len(lines) == 3
    first = lines[0]
    assert first["port"] == PORT
    assert first["envelope"]["type"] == "Light/1" and first["envelope"]["valid"] is True
    assert len(bytes.fromhex(first["envelope"]["source"])) == 16
    assert first["data"]["point"] == LIGHT.point.tolist()
    assert first["data"]["lit"] == [True, False]
    assert first["data"]["shade"] is None
    assert first["data"]["colours"] == ["red", "green"]
    numbers = [line["envelope"]["seq"] for line in lines]
    assert numbers == list(range(numbers[0], numbers[0] + 3))


def test_hz_measures_rate_and_losses(ask):
    status, [result] = ask("hz", PORT, "--seconds", "2")
    assert status == 0 and result["port"] == PORT
    assert 20.0 < result["hz"] < 110.0
    assert 0.0 < result["period_p50"] <= result["period_p99"] <= result["period_max"]
    assert result["received"] > 10 and result["lost"] < 10


def test_rpc_passes_arguments_and_prints_the_answer(ask):
    for name in ("/beacon/rpc:i", "beacon"):
        assert ask("rpc", name, "shine", "brightness=0.5") == (0, [{"brightness": 0.5}])


@pytest.mark.parametrize("words", [("rpc", PORT), ("param", "list", PORT)])
def test_a_port_that_cannot_be_asked_is_wrong_usage_at_once(words, bus, capsys):
    assert run([*words, "--connect", bus]) == 2
    shown = capsys.readouterr().err
    assert f"{PORT} is an output, expected an RPC port such as /beacon/rpc:i" in shown


def test_status_without_a_launcher_lists_the_ready_services(ask):
    status, [rows] = ask("status")
    beacon = next(row for row in rows if row["service"] == "beacon")
    assert status == 0 and beacon["ready"] is True and beacon["restarts"] is None


def test_check_looks_at_machine_hub_services_and_rates(ask):
    _, [rows] = ask("check")
    results = {row["check"]: row["result"] for row in rows}
    assert results["python"] == results["packages"] == results["robot"] == results["hub"] == "ok"
    assert results["service beacon"] == "ok"
    assert f"port {PORT}" in results


@pytest.mark.parametrize("verb", ["info", "read", "hz", "rpc"])
def test_an_unknown_port_is_one_line_with_near_names(verb, bus, capsys):
    assert run([verb, "/beacon/ligth:o", "--connect", bus]) == 2
    shown = capsys.readouterr().err
    assert "unknown port /beacon/ligth:o" in shown and PORT in shown
    assert shown.count("\n") == 1


def test_a_refused_request_is_one_line_and_status_1(bus, capsys):
    assert run(["rpc", "/beacon/rpc:i", "shien", "--connect", bus]) == 1
    shown = capsys.readouterr().err
    assert "did you mean shine" in shown and shown.count("\n") == 1


def test_read_is_quiet_when_its_reader_goes(bus):
    command = [sys.executable, "-m", "deploy.main", "read", PORT, "--json", "--connect", bus]
    with subprocess.Popen(command, stdout=subprocess.PIPE, stderr=subprocess.PIPE) as reader:
        assert reader.stdout is not None and reader.stderr is not None
        assert reader.stdout.readline().startswith(b'{"port"')
        reader.stdout.close()
        assert reader.wait(5.0) == 0
        assert reader.stderr.read() == b""


def test_port_verbs_load_no_robot_package(toy_bus):
    arguments = [sys.executable, "-c", WITHOUT_ROBOT, toy_bus, "/toy/out:o", "/toy/in:i"]
    done = subprocess.run(arguments, capture_output=True, text=True, timeout=120)
    assert done.stdout.splitlines()[-1] == "[]", done.stderr
