"""Playing recordings from the command line; needs the kept recording only."""

import os
import pty
import subprocess
import sys

import pytest

from bus import BusError, Node
from bus.clock import Clock
from bus.testing import Process, collect, eventually
from deploy.main import run
from deploy.playing import bar
from deploy.replay import replay_application
from robot_model import load_robot
from robot_model.messages import JointTorques, SensorFrame
from tests.system.lockstep_runs import REFERENCE

STATUS = {"position": 5.0, "duration": 10.0, "rate": 1.0, "paused": False, "ended": False}


def ask(node: Node, verb: str, **arguments):
    return node.call("/player/rpc:i", verb, arguments)


def playing(node: Node) -> bool:
    """Whether a player answers."""
    try:
        return bool(ask(node, "status"))
    except BusError:
        return False


def test_a_recording_is_played_to_its_end(hub: str, node: Node):
    robot = load_robot("icub")
    sizes = {"model": robot.model_hash, "dimensions": robot.dimensions}
    frames = node.input("/test/sensors:i", SensorFrame, "/log/icub/sensors:o", depth=256, **sizes)
    clock = node.input("/test/clock:i", Clock, "/log/icub/clock:o", depth=256)
    node.ready()
    arguments = ("--prefix", "/log", "--rate", "0.5", "--paused", "-e", hub)
    process = Process("deploy.main", "play", str(REFERENCE), "/icub/sensors:o", *arguments)
    try:
        eventually(lambda: playing(node))
        eventually(lambda: node.directory.leader("/log/icub/sensors:o"))
        ask(node, "resume")
        received = collect(node, frames, 50)
        stamps = [message.envelope.stamp for message in received]
        assert stamps == sorted(stamps) and received[0].data.q.shape == (robot.n,)
        assert process.ended(30.0) == 0
        assert "messages of 1 ports" in process.output
        times = []
        while (tick := clock.read()) is not None:
            times.append(tick.data.time)
        assert times and times == sorted(times)
    finally:
        process.clean_up()


def test_keys_pause_step_and_end_it(hub: str, node: Node):
    node.ready()
    terminal, end = pty.openpty()
    command = [sys.executable, "-m", "deploy.main", "play", str(REFERENCE), "/icub/base:o"]
    process = subprocess.Popen(
        [*command, "--rate", "0.01", "-e", hub], stdin=end, stdout=end, stderr=end
    )
    try:
        eventually(lambda: playing(node))
        os.write(terminal, b" ")
        eventually(lambda: ask(node, "status")["paused"])
        before = ask(node, "status")["position"]
        os.write(terminal, b"s")
        eventually(lambda: ask(node, "status")["position"] > before)
        os.write(terminal, b"\x1b[A")
        eventually(lambda: ask(node, "status")["rate"] == 0.02)
        os.write(terminal, b"q")
        assert process.wait(20.0) == 0
        assert b"space pause" in os.read(terminal, 65536)
    finally:
        process.kill()
        process.wait()
        os.close(end)
        os.close(terminal)


def test_the_bar_shows_where_we_are():
    assert bar(STATUS).startswith(f"[{'#' * 15}{'-' * 15}] 5.0 / 10.0 s  x1")
    assert "  paused  " in bar(STATUS | {"paused": True})
    assert "  ended  " in bar(STATUS | {"paused": True, "ended": True})


@pytest.mark.parametrize(
    ("arguments", "expected"),
    [
        (["play", "no_such.mcap"], "no_such.mcap"),
        (["play", str(REFERENCE), "/icub/sensrs:o"], "did you mean /icub/sensors:o"),
        (["play", str(REFERENCE), "--from", "100"], "expected from < to"),
        (["replay", "no_such.mcap"], "no_such.mcap"),
        (["replay", str(REFERENCE), "--from", "2", "--to", "1"], "expected more than --from"),
    ],
)
def test_a_wrong_request_is_one_line(arguments, expected, hub, capsys, monkeypatch):
    monkeypatch.setenv("WRENCHBUS_CONNECT", hub)
    assert run(arguments) in (1, 2)
    shown = capsys.readouterr()
    assert shown.out == "" and expected in shown.err and shown.err.count("\n") == 1


def test_a_replay_puts_the_recording_in_the_place_of_the_robot():
    application = replay_application(REFERENCE, None, "floor", True, {"rate": 0.5})
    server = application.services["sensor_server"]
    assert "robot_sim" not in application.services
    assert server.params["driver"] == "replay" and server.params["rate"] == 1000.0
    assert server.params["replay"]["file"] == str(REFERENCE)
    participants = server.params["replay"]["participants"]
    assert set(participants) >= {"torque_observer", "base_estimator", "gravity_compensator"}
    assert all(application.services[name].params["lockstep"] for name in participants)
    assert application.services["dashboard"].params["replay"]


def test_services_follow_the_clock_of_what_is_played(hub: str, node: Node, start):
    robot = load_robot("icub")
    sizes = {"model": robot.model_hash, "dimensions": robot.dimensions}
    torques = node.input("/test/torques:i", JointTorques, "/icub/torques:o", depth=256, **sizes)
    node.ready()
    start("services.torque_observer")
    arguments = ("--rate", "4", "--loop", "-e", hub)
    process = Process("deploy.main", "play", str(REFERENCE), "/icub/sensors:o", *arguments)

    def clock() -> str:
        return node.call("/torque_observer/rpc:i", "status")["clock"]

    def observed() -> bool:
        node.wait(0.01)
        received = torques.newest()
        return received is not None and received.envelope.valid

    try:
        eventually(observed)
        assert torques.latest.envelope.stamp % 4_000_000 == 0 and torques.latest.envelope.clock == 1
        assert clock() == "running"
        ask(node, "pause")
        eventually(lambda: clock() == "paused")
        ask(node, "resume")
        eventually(lambda: clock() == "running")
        eventually(observed)
        process.stop()
        eventually(lambda: clock() == "absent")
    finally:
        process.clean_up()
