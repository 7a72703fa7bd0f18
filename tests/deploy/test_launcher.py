"""The launcher, with services that need no robot."""

import json
import os
import signal
import time

import pytest

from bus.testing import eventually, free_port
from deploy.main import run

TWO = """
common: {colour: red}
services:
  one: {module: tests.deploy.beacon, params: {height: 3}}
  two: {module: tests.deploy.beacon, nice: 5}
once_ready:
  - {port: "/one/rpc:i", verb: shine, args: {brightness: 1.0}}
"""


OPEN = "desk: {listen: tcp/0.0.0.0:0}"


def is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


@pytest.fixture
def status(capsys):
    """Return ``status()``: what ``wrenchbus status --json`` tells, by service."""

    def asked():
        assert run(["status", "--json"]) == 0
        return {row["service"]: row for row in json.loads(capsys.readouterr().out)}

    return asked


@pytest.fixture
def two(launch, application):
    """Two beacons under a launcher."""
    command = launch("up", application(TWO))
    command.until("stop:    Ctrl-C")
    return command


def test_all_services_become_ready_with_their_settings_and_requests_are_sent(two, status):
    rows = status()
    assert list(rows) == ["hub", "one", "two"]
    assert all(row["ready"] and row["state"] == "ready" for row in rows.values())
    assert all(row["restarts"] == 0 and row["uptime_s"] > 0 for row in rows.values())
    assert os.getpriority(os.PRIO_PROCESS, rows["two"]["pid"]) >= 5
    assert '     one | settings {"colour": "red", "height": 3}' in two.errors
    eventually(lambda: "launcher | shine /one/rpc:i: done" in two.errors)


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM, signal.SIGHUP])
def test_a_signal_ends_everything_with_status_0(two, status, runtime_directory, number):
    [file] = runtime_directory.glob("*.json")
    entry = json.loads(file.read_text())
    assert entry["pid"] == two.popen.pid and entry["endpoint"].startswith("tcp/127.0.0.1:")
    pids = [row["pid"] for row in status().values()]
    two.popen.send_signal(number)
    assert two.end() == 0
    assert not any(map(is_alive, pids))
    assert list(runtime_directory.glob("*.json")) == []
    assert "Traceback" not in two.errors


def test_a_killed_launcher_leaves_nothing_running(two, status):
    pids = [row["pid"] for row in status().values()]
    two.popen.kill()
    eventually(lambda: not any(map(is_alive, pids)))


def test_what_dies_is_started_again_and_the_others_go_on(two, status):
    before = status()
    os.kill(before["one"]["pid"], signal.SIGKILL)
    eventually(lambda: status()["one"]["restarts"] == 1 and status()["one"]["ready"])
    assert status()["two"]["pid"] == before["two"]["pid"]
    assert "one | died (SIGKILL), starts again in 0.5 s" in two.errors


def test_the_hub_is_started_again_too(two, status, capsys):
    os.kill(status()["hub"]["pid"], signal.SIGKILL)
    eventually(lambda: "hub | died" in two.errors)
    eventually(lambda: run(["list"]) == 0)
    capsys.readouterr()
    assert status()["hub"]["restarts"] == 1


def test_a_service_that_does_not_end_is_killed_within_five_seconds(launch, application, status):
    text = "services: {one: {module: tests.deploy.beacon, params: {stubborn: true}}}"
    command = launch("up", application(text))
    command.until("stop:    Ctrl-C")
    pid = status()["one"]["pid"]
    command.popen.terminate()
    assert command.end(10.0) == 0  # 3 s on a quiet machine
    assert not is_alive(pid)


def test_seconds_end_the_run(launch, application):
    start = time.monotonic()
    command = launch("up", application(TWO), "--seconds", "3")
    assert command.end() == 0
    assert time.monotonic() - start > 3.0


def test_wrong_settings_end_the_start_with_status_2(launch, application):
    text = "services: {one: {module: tests.deploy.beacon, params: {wrong: true}}}"
    command = launch("up", application(text))
    assert command.end() == 2
    assert "one | one: wrong: unknown key" in command.errors
    assert command.errors.endswith("wrenchbus: one refused its settings; see its message above\n")
    assert command.errors.count("unknown key") == 1


def on_two_hosts(port: int) -> str:
    """Return an application of two hosts, which both are this machine."""
    return f"""
hosts:
  robot: {{listen: tcp/127.0.0.1:0}}
  desk: {{listen: tcp/127.0.0.1:0}}
hub: {{host: robot, endpoint: tcp/127.0.0.1:{port}, namespace: lab}}
services:
  one: {{module: tests.deploy.beacon, host: robot}}
  two: {{module: tests.deploy.beacon, host: desk}}
once_ready:
  - {{port: "/two/rpc:i", verb: shine, args: {{brightness: 1.0}}}}
"""


def test_each_host_runs_its_part_and_down_ends_all(launch, application, status):
    file = application(on_two_hosts(free_port()))
    desk = launch("up", file, "--host", "desk")
    eventually(lambda: "launcher | waits for the hub of host robot at tcp/127" in desk.errors)
    robot = launch("up", file, "--host", "robot")
    robot.until("running: hub, one\n")
    desk.until("running: two\n")
    eventually(lambda: "launcher | shine /two/rpc:i: done" in robot.errors)
    assert "shine" not in desk.errors
    rows = status()
    assert {name: row["host"] for name, row in rows.items()} == {
        **{"hub": "robot", "one": "robot", "two": "desk"}
    }
    assert all(row["ready"] for row in rows.values())
    assert run(["down"]) == 0
    assert robot.end(10.0) == desk.end(10.0) == 0
    assert not any(is_alive(row["pid"]) for row in rows.values())


def test_a_host_that_is_not_up_is_waited_for_and_shown_as_absent(launch, application, status):
    robot = launch("up", application(on_two_hosts(free_port())), "--host", "robot")
    robot.until("running: hub, one\n")
    eventually(lambda: "launcher | waits for two of desk" in robot.errors)
    assert "shine" not in robot.errors
    row = status()["two"]
    assert (row["state"], row["ready"], row["pid"], row["host"]) == ("absent", False, None, "desk")


def test_who_waits_for_a_hub_can_be_ended(launch, application):
    desk = launch("up", application(on_two_hosts(free_port())), "--host", "desk")
    eventually(lambda: "waits for the hub" in desk.errors)
    desk.popen.terminate()
    assert desk.end(5.0) == 0


def test_links_to_other_machines_need_a_flag(application, capsys):
    text = on_two_hosts(7512).replace("desk: {listen: tcp/127.0.0.1:0}", OPEN)
    assert run(["up", application(text), "--host", "desk"]) == 1
    assert "tcp/0.0.0.0:0 leaves this machine" in capsys.readouterr().err


def test_two_applications_run_at_once_and_verbs_ask_which(launch, application, capsys):
    for _ in range(2):
        launch("up", application(TWO)).until("stop:    Ctrl-C")
    assert run(["list"]) == 1
    shown = capsys.readouterr().err
    assert "several buses are running" in shown and shown.count("tcp/127.0.0.1:") == 2


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("services: {one: {modul: beacon}}", "services.one.modul: Extra inputs"),
        ("services: {}", "services: "),
        ("services: {one: {module: beacon, nice: 30}}", "services.one.nice: "),
        ("services: {hub: {module: beacon}}", "'hub' is taken"),
        ("services: {one: {module: beacon, host: a/b}}", "services.one.host: "),
        (TWO + "hosts: {robot: {listen: tcp/1.2.3.4:0, port: 1}}", "hosts.robot.port: Extra"),
        (on_two_hosts(0), "hub.endpoint: expected a certain port, got tcp/127.0.0.1:0"),
        (on_two_hosts(7512).replace(", namespace: lab", ""), "hub.namespace: expected a name"),
        (on_two_hosts(7512).replace("  desk: {l", "  disk: {l"), "hosts: 'desk'"),
        ("- 1", "file: "),
        ("[1", "line 1, column 1"),
    ],
)
def test_a_bad_application_file_is_one_line_and_status_2(text, expected, application, capsys):
    assert run(["up", application(text)]) == 2
    shown = capsys.readouterr().err
    assert expected in shown and "application.yaml" in shown
    assert shown.count("\n") == 1
