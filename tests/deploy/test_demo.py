"""The demo from the terminal, without a browser."""

import json
import os
import re
import signal
import urllib.request

import pytest

from bus.testing import eventually
from deploy.main import run

pytestmark = [pytest.mark.system, pytest.mark.timeout(900)]

# on a loaded machine a robot in real time does not come to rest, and is not tared
SLOW = ("--no-browser", "--speed", "0.3")
SERVICES = [
    "hub",
    "robot_sim",
    "sensor_server",
    "base_estimator",
    "torque_observer",
    "gravity_compensator",
    "contact_detector",
    "dashboard",
    "recorder",
]


@pytest.fixture
def ask(capsys):
    """Return ``ask(*arguments)``: the JSON document that a verb prints."""

    def answered(arguments):
        status = run([*arguments, "--json"])
        shown = capsys.readouterr()
        late = "no answer within" in shown.err  # of a loaded machine
        assert status == 0 or late, shown.err
        return not late and shown.out

    def asked(*arguments):
        return json.loads(eventually(lambda: answered(arguments)))

    return asked


def endpoint(command):
    """Return where a demo's hub listens."""
    found = re.search(r"bus: +(\S+)", command.output)
    assert found
    return found[1]


def is_alive(pid):
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    return True


def assert_tared(demo):
    for service in ("torque_observer", "contact_detector"):
        done = f"launcher | tare /{service}/rpc:i: done"
        eventually(lambda done=done: done in demo.errors, 240.0, f"{done}, got {demo.errors}")


def assert_takes_pushes(demo, ask, capsys):
    eventually(lambda: "launcher | scenario /robot_sim/rpc:i: done" in demo.errors)
    push = ["push", "l_forearm", "--force", "0,0,-10", "--frame", "world"]
    assert {"push_id", "start_stamp"} <= ask(*push).keys()
    assert run(["push", "l_foream", "--force", "0,0,-10"]) == 1
    shown = capsys.readouterr().err
    assert "l_forearm" in shown and shown.count("\n") == 1


def assert_can_be_stopped(ask):
    ask("stop")
    assert ask("rpc", "/sensor_server/rpc:i", "status")["stopped"] is True
    ask("stop", "--release")
    assert ask("rpc", "/sensor_server/rpc:i", "status")["stopped"] is False


def pids_of(demo, ask):
    """Return the processes of a demo that is ready."""

    def ready():  # a loaded machine is slow to hear of all
        rows = ask("status", "--connect", endpoint(demo))
        return rows if [row["service"] for row in rows if row["ready"]] == SERVICES else []

    return [row["pid"] for row in eventually(ready)]


def test_two_demos_run_at_once_are_tared_and_pushed_and_leave_nothing_behind(
    launch, ask, capsys, runtime_directory
):
    demo = launch("demo", *SLOW)
    demo.until("stop:    Ctrl-C")
    page = re.search(r"page: +(\S+)", demo.output)
    assert page and b"<html" in urllib.request.urlopen(page[1], timeout=60.0).read().lower()
    assert_tared(demo)
    assert_takes_pushes(demo, ask, capsys)
    assert_can_be_stopped(ask)

    other = launch("demo", *SLOW, "--profile", "ideal")
    other.until("stop:    Ctrl-C")
    pids = pids_of(demo, ask) + pids_of(other, ask)
    assert len(set(pids)) == 2 * len(SERVICES)
    for either in (demo, other):
        either.popen.send_signal(signal.SIGINT)
    assert [demo.end(20.0), other.end(20.0)] == [0, 0]
    assert not any(map(is_alive, pids))
    assert list(runtime_directory.glob("*.json")) == []
    assert "Traceback" not in demo.errors + other.errors


def test_the_demo_ends_by_itself(launch):
    demo = launch("demo", "--no-browser", "--seconds", "2", "--base", "fixed")
    assert demo.end() == 0
    assert "Traceback" not in demo.errors
