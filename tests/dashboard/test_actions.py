"""What the buttons ask of whom, and what they show of the answer."""

from collections import deque
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from bus import RpcAbsent, RpcError
from dashboard import recording
from dashboard.actions import Actions
from dashboard.config import DashboardConfig
from dashboard.errands import Outcome
from dashboard.html import RED
from dashboard.panel import Click
from dashboard.picking import Ray
from dashboard.placement import Placement
from robot_model import Robot

SIGHT = np.array([0.0, -1.0, 0.0])  # of who clicks, world


class Answers:
    """Errands that are carried out at once, by whoever has an answer."""

    def __init__(self) -> None:
        self.asked: list[tuple[str, str, dict[str, Any]]] = []
        self.answers: dict[str, Any] = {}

    def send(self, label, port, verb, arguments, timeout, then) -> None:
        self.asked.append((port, verb, arguments))
        answer = self.answers.get(port, RpcAbsent(f"nobody answers on {port}"))
        failed = isinstance(answer, Exception)
        then(Outcome(label, None if failed else answer, answer if failed else None))

    def collect(self) -> None:
        pass


@pytest.fixture
def panel():
    choice = {"link": "l_forearm", "direction": "-y", "force": 12.0}
    widgets = {name: SimpleNamespace(value=value) for name, value in choice.items()}
    return SimpleNamespace(clicks=deque(), result=SimpleNamespace(content=""), **widgets)


@pytest.fixture
def errands():
    return Answers()


@pytest.fixture
def actions(panel, errands, robot, placement):
    return Actions(panel, errands, robot, robot.load_surface(), placement, DashboardConfig())


def press(actions: Actions, panel: Any, button: str) -> str:
    panel.clicks.append(Click(button, None))
    actions.run()
    return panel.result.content


def test_push_asks_the_simulator_for_a_force_along_a_world_axis(actions, panel, errands):
    errands.answers["/icub/sim/rpc:i"] = {"push_id": 3, "start_stamp": 1}
    shown = press(actions, panel, "push")
    port, verb, push = errands.asked[0]
    assert (port, verb) == ("/icub/sim/rpc:i", "push")
    assert (push["link"], push["frame"]) == ("l_forearm", "world")
    assert push["force"] == pytest.approx([0.0, -12.0, 0.0])
    assert "push 12 N -y on l_forearm: push_id 3" in shown


def test_push_without_a_simulator_says_so(actions, panel):
    assert "nobody answers on /icub/sim/rpc:i" in press(actions, panel, "push")


def click_on_the_head(actions: Actions, panel: Any, robot: Robot, placement: Placement) -> None:
    (head,) = (body for body in robot.load_surface().bodies if body.name == "head")
    middle = placement.point("head", head.center)
    panel.clicks.append(Click("poke", None, Ray(middle - 2.0 * SIGHT, SIGHT)))
    actions.run()


def test_click_on_the_robot_pushes_it_there_straight_inwards(
    actions, panel, errands, robot, placement
):
    errands.answers["/icub/sim/rpc:i"] = {"push_id": 4, "start_stamp": 1}
    click_on_the_head(actions, panel, robot, placement)
    _, verb, push = errands.asked[0]
    assert (verb, push["link"], push["frame"]) == ("push", "head", "link")
    assert np.linalg.norm(push["force"]) == pytest.approx(12.0)
    assert placement.vector("head", np.array(push["force"])) @ SIGHT > 6.0
    assert "push 12 N on head where it was clicked: push_id 4" in panel.result.content


def test_click_beside_the_robot_pushes_nothing(actions, panel, errands):
    panel.clicks.append(Click("poke", None, Ray(np.full(3, 9.0), np.array([1.0, 0.0, 0.0]))))
    actions.run()
    assert not errands.asked
    assert "nothing of the robot is there" in panel.result.content


def test_click_on_a_robot_without_a_simulator_says_so(actions, panel, robot, placement):
    click_on_the_head(actions, panel, robot, placement)
    assert "no simulator to push: nobody answers on /icub/sim/rpc:i" in panel.result.content


def test_refused_tare_is_shown_with_its_reason(actions, panel, errands):
    errands.answers["/torque_observer/rpc:i"] = {"tared": ["l_arm_ft"], "message": "tared 1 of 6"}
    errands.answers["/contact_detector/rpc:i"] = RpcError("the robot moves: l_elbow at 0.3 rad/s")
    panel.result = Recorder()
    press(actions, panel, "tare")
    assert [verb for _, verb, _ in errands.asked] == ["tare", "tare"]
    assert any("tare torque_observer: tared 1 of 6" in text for text in panel.result.shown)
    refusal = "tare contact_detector: the robot moves: l_elbow at 0.3 rad/s"
    assert f"{refusal}; tare torque_observer: tared 1 of 6" in panel.result.shown[-1]


class Recorder:
    """A widget that remembers everything it showed."""

    def __init__(self) -> None:
        self.shown: list[str] = []

    @property
    def content(self) -> str:
        return self.shown[-1]

    @content.setter
    def content(self, text: str) -> None:
        self.shown.append(text)


def test_pause_pauses_the_simulator_and_then_resumes_it(actions, panel, errands):
    errands.answers["/icub/sim/rpc:i"] = {"time": 0}
    press(actions, panel, "pause")
    actions.paused = True  # as the clock says
    press(actions, panel, "pause")
    assert [verb for _, verb, _ in errands.asked] == ["pause", "resume"]
    assert not actions.frozen


def test_pause_without_a_simulator_freezes_the_page_until_pressed_again(actions, panel):
    assert "only this page" in press(actions, panel, "pause")
    assert actions.frozen
    press(actions, panel, "pause")
    assert not actions.frozen


def test_stop_becomes_release_while_the_robot_holds(actions, panel, errands):
    errands.answers["/sensor_server/rpc:i"] = None
    press(actions, panel, "stop")
    actions.holding = True
    press(actions, panel, "stop")
    assert [verb for _, verb, _ in errands.asked] == ["stop", "release"]


def status(**more):
    told = {"recording": True, "file": "/data/walk.mcap", "size": 12_345_678, "seconds": 94.2}
    return {**told, "lost": 0, "warning": "", "error": "", **more}


def test_record_starts_a_recording_and_then_finishes_it(actions, panel, errands):
    errands.answers["/recorder/rpc:i"] = status(size=0, seconds=0.1)
    assert "recording walk.mcap, 0.0 MB, 0:00, 0 lost" in press(actions, panel, "record")
    actions.recording = True
    errands.answers["/recorder/rpc:i"] = status(recording=False, lost=3)
    assert "recorded walk.mcap, 12.3 MB, 1:34, 3 lost" in press(actions, panel, "record")
    assert [verb for _, verb, _ in errands.asked] == ["start", "stop"]


def test_record_without_a_recorder_says_so(actions, panel):
    assert "nobody answers on /recorder/rpc:i" in press(actions, panel, "record")


def test_the_recording_line_shows_name_size_duration_and_what_is_wrong():
    assert recording.label({}) == "Record" and "<div" in recording.line({})
    assert recording.label(status()) == "Finish recording"
    assert "recording walk.mcap, 12.3 MB, 1:34, 0 lost<" in recording.line(status())
    full = status(recording=False, error="walk.mcap: No space left on device")
    assert "No space left on device" in recording.line(full) and RED in recording.line(full)


def test_the_recorders_label_disturbs_no_pinned_button():
    for label in (recording.BEGIN, recording.END):
        assert not any(name in label for name in ("Push", "Tare", "Pause", "Stop"))


def test_pause_is_the_players_while_a_recording_is_played(actions, panel, errands):
    errands.answers["/player/rpc:i"] = {"position": 1.0}
    actions.replaying = True
    assert "pause: the recording is at 1.0 s" in press(actions, panel, "pause")
    actions.paused = True
    press(actions, panel, "pause")
    assert [asked[:2] for asked in errands.asked] == [
        ("/player/rpc:i", "pause"),
        ("/player/rpc:i", "resume"),
    ]
    assert not actions.frozen
