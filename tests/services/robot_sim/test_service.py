"""The plant as a process: its ports, its verbs, its pace, and how it ends."""

import numpy as np
import pytest
from pydantic import BaseModel

from bus import Node, RpcError
from bus.clock import Clock
from bus.parameters import Parameters
from bus.testing import Process, eventually
from robot_model import load_robot
from robot_model.messages import GroundTruth, MotorCommand, RawFrame

pytestmark = pytest.mark.system

SIM = "/icub/sim/rpc:i"
PAUSED = ("--set", "paused=true", "--set", "pace=fast")
MS = 1_000_000


@pytest.fixture(scope="module")
def robot():
    return load_robot("icub")


class Observer:
    """What a test sees of the plant's ports."""

    def __init__(self, node, robot):
        sizes = {"model": robot.model_hash, "dimensions": robot.dimensions}
        self.node, self.robot = node, robot
        self.raw = node.input("/test/raw:i", RawFrame, "/icub/raw:o", 4096, 1000.0, **sizes)
        self.truth = node.input("/test/truth:i", GroundTruth, "/icub/truth:o", 4096, **sizes)
        self.clock = node.input("/test/clock:i", Clock, "/icub/clock:o", 64)
        self.command = node.output("/icub/robot_sim/motor_command:i", MotorCommand, **sizes)

    def ask(self, verb, **arguments):
        return self.node.call(SIM, verb, arguments, 20.0)

    def ready(self):
        """Open the ports, and wait until what the plant writes arrives here."""
        self.node.ready()
        self.ask("step", ticks=1)
        eventually(lambda: self.raw.newest() or self.ask("step", ticks=4) is None)
        return self

    def stepped(self, ticks):
        """Step a paused plant; return the raw messages of these ticks."""
        self.raw.newest()
        self.truth.newest()
        messages = []
        while ticks > 0:  # a few at a time: a loaded link drops what comes in bursts
            last = self.ask("step", ticks=min(ticks, 4))["time"]
            ticks -= 4

            def complete(last=last):
                while (received := self.raw.read()) is not None:
                    messages.append(received)
                return messages and messages[-1].envelope.stamp == last

            eventually(complete)
        return messages

    def told(self):
        """Return the truth of the last tick stepped, which is a multiple of 4 ms."""
        return eventually(self.truth.newest)


@pytest.fixture
def observer(node, robot):
    return Observer(node, robot)


def test_paused_it_steps_tick_by_tick_and_reset_reproduces_the_run(start, observer):
    start("robot_sim", *PAUSED, "--set", "profile=realistic")
    observer.ready()
    observer.ask("reset")
    first = observer.stepped(40)
    assert [message.envelope.stamp for message in first] == [MS * (i + 1) for i in range(40)]
    assert {message.envelope.clock for message in first} == {1}
    assert eventually(observer.clock.newest, 60.0).data.state == "paused"
    assert observer.ask("reset") == {"time": 0}
    second = observer.stepped(40)
    for one, other in zip(first, second, strict=True):
        assert np.array_equal(one.data.q, other.data.q)
        assert np.array_equal(one.data.ft, other.data.ft)
        assert np.array_equal(one.data.imu_acc, other.data.imu_acc)


def test_it_runs_in_real_time_and_pauses_and_resumes(start, observer):
    start("robot_sim")
    observer.node.ready()
    status = observer.ask("status")
    assert status["clock"] == "running" and status["base"] == "free"
    received = eventually(lambda: observer.raw.newest(), 60.0)
    assert received.envelope.valid and received.data.q.shape == (32,)
    stopped = observer.ask("pause")["time"]
    assert observer.ask("status")["time"] == stopped
    assert observer.ask("resume")["time"] == stopped
    with pytest.raises(RpcError, match="pause it before stepping"):
        observer.ask("step", ticks=1)
    eventually(lambda: observer.ask("status")["time"] > stopped, 60.0)


def speed_of(observer):
    """Of simulated to wall time, between two frames; a stall makes it smaller, never larger."""
    observer.raw.newest()
    first, last = (eventually(observer.raw.newest).envelope for _ in range(2))
    return (last.stamp - first.stamp) / (last.acquired - first.acquired)


def test_it_goes_slower_for_a_while_or_for_good(start, observer):
    start("robot_sim")
    observer.node.ready()
    eventually(lambda: speed_of(observer) > 0.1)
    observer.ask("slow_down", seconds=60.0, speed=0.05)
    eventually(lambda: speed_of(observer) < 0.07)
    observer.ask("slow_down", seconds=1e-3)
    eventually(lambda: speed_of(observer) > 0.1)
    observer.ask("param", action="set", name="speed", value=0.05)
    eventually(lambda: speed_of(observer) < 0.07)


def test_a_push_begins_at_the_stamp_that_was_answered(start, observer):
    start("robot_sim", *PAUSED)
    observer.ready()
    observer.ask("reset")
    observer.stepped(8)
    answer = observer.ask("push", link="l_forearm", force=[0, 5, 0], frame="world", duration=1.0)
    assert answer["start_stamp"] == 9 * MS
    observer.stepped(4)
    push = observer.told().data.pushes[0]
    assert push["id"] == answer["push_id"] and push["link"] == "l_forearm"
    assert push["force_world"] == pytest.approx([0.0, 5.0, 0.0])
    assert observer.ask("release", push_id=answer["push_id"]) == {"released": [answer["push_id"]]}
    observer.stepped(4)
    assert observer.told().data.pushes == []


@pytest.mark.parametrize(
    ("verb", "arguments", "text"),
    [
        ("push", {"link": "l_forarm", "force": [1, 0, 0]}, "did you mean 'l_forearm'"),
        ("push", {"link": "chest", "force": [1, 0]}, "force must be 3 finite numbers"),
        ("push", {"link": "chest"}, "force"),
        ("release", {"push_id": 99}, "push 99 does not act now"),
        ("step", {"ticks": 0}, "ticks must be a whole number"),
        ("slow_down", {"seconds": 1e3}, "at most 60 s and a speed of at most 1, got 1000.0 s"),
        ("base", {"mode": "flying"}, "expected 'free' or 'fixed'"),
        ("motion", {"name": "dance"}, "no motion 'dance'"),
        ("profile", {"name": "idael"}, "did you mean 'ideal'"),
        (
            "param",
            {"action": "set", "name": "truth", "value": False},
            "only profile and speed can change",
        ),
    ],
)
def test_a_wrong_request_is_answered_with_what_is_wrong(plant_for_errors, verb, arguments, text):
    with pytest.raises(RpcError, match=text):
        plant_for_errors.call(SIM, verb, arguments, 20.0)


@pytest.fixture(scope="module")
def plant_for_errors(tmp_path_factory):
    """One paused plant and one node for all wrong requests."""
    from bus.introspection import wait_for_service
    from bus.testing import free_port

    endpoint = f"tcp/127.0.0.1:{free_port()}"
    hub = Process("bus.hub", "--listen", endpoint, "--settle", "0", "--no-announce")
    plant = Process("robot_sim", "--connect", endpoint, *PAUSED)
    try:
        with Node("test", connect=endpoint, signals=False) as node:
            node.ready(30.0)
            wait_for_service(node, "robot_sim", 30.0)
            yield node
        assert plant.stop() == 0
    finally:
        plant.clean_up()
        hub.clean_up()


def test_the_boards_obey_motor_commands_and_refuse_another_robots(start, observer):
    start("robot_sim", *PAUSED)
    observer.ready()
    observer.ask("reset")
    robot = observer.robot
    torque = np.linspace(-1.0, 1.0, robot.n)
    command = MotorCommand(mode="torque", value=torque, feedforward=np.zeros(robot.n))
    observer.command.write(command, stamp=0, clock=1)
    obeyed = eventually(lambda: _obeys(observer, torque))
    assert obeyed
    stranger = observer.node.output(
        "/icub/robot_sim/motor_command:i", MotorCommand, model="0badc0de"
    )
    stranger.write(MotorCommand(mode="torque", value=3 * torque, feedforward=torque), stamp=0)
    observer.command.write(command, stamp=0, clock=1)
    assert eventually(lambda: _obeys(observer, torque))


def own_line(process):
    """Return the one line that the process itself wrote; Zenoh may add its own."""
    lines = [line for line in process.output.splitlines() if line and "zenoh" not in line]
    assert len(lines) == 1, process.output
    return lines[0]


def _obeys(observer, torque):
    frame = observer.stepped(4)[-1].data
    lag = 1e-3 * observer.robot.viscous * frame.ddq
    return np.abs(frame.motor_torque + lag - torque).max() < 1e-9


def test_without_truth_the_port_is_absent_and_the_raw_frames_are_the_same(start, node, robot):
    frames = {}
    for truth in ("true", "false"):
        process = start("robot_sim", *PAUSED, "--set", f"truth={truth}")
        with Node(f"look_{truth}", connect=node.endpoint, signals=False) as own:
            observer = Observer(own, robot).ready()
            observer.ask("reset")
            frames[truth] = observer.stepped(20)
            assert (own.directory.leader("/icub/truth:o") is not None) == (truth == "true")
        assert process.stop() == 0
        eventually(lambda: node.directory.leader("/icub/raw:o") is None, 60.0)
    for one, other in zip(frames["true"], frames["false"], strict=True):
        assert np.array_equal(one.data.ft, other.data.ft)


class Supported(BaseModel):
    robot: str = "icub"
    support: str = "floor"


def test_changing_the_base_tells_the_services_of_this_robot(start, hub, observer):
    start("robot_sim", *PAUSED)
    with (
        Node("mine", connect=hub, signals=False, parameters=Parameters(Supported())) as mine,
        Node(
            "other", connect=hub, signals=False, parameters=Parameters(Supported(robot="talos"))
        ) as other,
    ):
        mine.ready()
        other.ready()
        observer.ready()
        from threading import Event, Thread

        done = Event()

        def serve(service):
            while not done.is_set():
                service.wait(0.01)

        threads = [Thread(target=serve, args=(each,)) for each in (mine, other)]
        for thread in threads:
            thread.start()
        try:
            answer = observer.ask("base", mode="fixed")
        finally:
            done.set()
            for thread in threads:
                thread.join()
        assert answer["told"] == ["mine"] and answer["support"] == "pole"
        assert mine.parameters.value.support == "pole"
        assert other.parameters.value.support == "floor"
    observer.stepped(4)
    truth = observer.told().data
    assert truth.support_frames == ["root_link"] and not truth.base_twist.any()


def test_in_lockstep_it_waits_for_the_participant_and_names_it(start, hub, robot):
    start("robot_sim", "--set", "lockstep=true", "--set", "participants=[slow]")
    with Node("slow", connect=hub, signals=False, lockstep=True) as slow:
        sizes = {"model": robot.model_hash, "dimensions": robot.dimensions}
        raw = slow.input("/slow/raw:i", RawFrame, "/icub/raw:o", 64, **sizes)
        slow.ready()
        named = "slow did not acknowledge 1000000 ns"
        eventually(lambda: named in slow.call(SIM, "status", {}, 60.0)["waiting_for"])
        assert slow.call(SIM, "status", {}, 60.0)["time"] == MS
        for tick in range(1, 30):
            received = eventually(raw.read, 60.0)
            assert received.envelope.stamp == tick * MS
            slow.acknowledge(tick * MS)


def test_a_blow_up_ends_the_process_with_one_line_and_no_nan_is_seen(start, observer):
    process = start("robot_sim", *PAUSED, "--set", "plant.floor.stiffness=1.0e+9")
    process.expected = 1
    observer.ready()
    observer.ask("resume")
    assert eventually(lambda: process.popen.poll() is not None)
    assert process.popen.returncode == 1
    assert own_line(process).startswith("robot_sim: the plant diverged at")
    while (received := observer.raw.read()) is not None:
        assert np.isfinite(received.data.ft).all()
    assert observer.raw.statistics.refused == 0


@pytest.mark.parametrize(
    ("setting", "status", "text"),
    [
        ("robot=icubb", 1, "icub"),
        ("profile=realistc", 1, "did you mean 'realistic'"),
        ("scenario=dmo", 1, "did you mean 'demo'"),
        ("base=flying", 2, "base"),
        ("plant.floor.stiffnes=1", 2, "stiffnes"),
        ("lockstep=true", 1, "participants"),
    ],
)
def test_a_wrong_setting_ends_the_process_with_one_line(hub, setting, status, text):
    process = Process("robot_sim", "--connect", hub, "--set", setting)
    try:
        assert process.popen.wait(20.0) == status
        assert text in own_line(process)
    finally:
        process.clean_up()
