"""The slider over a recording."""

from types import SimpleNamespace
from typing import Any

import pytest

from bus import RpcTimeout
from dashboard.errands import Outcome
from dashboard.replay_bar import PLAYER, ReplayBar
from dashboard.status import status


class Slider(SimpleNamespace):
    """As much of viser's as the bar uses."""

    def on_update(self, callback) -> None:
        self.callback = callback

    def move(self, value: float) -> None:
        """Move it as a browser does."""
        self.value = value
        self.callback(SimpleNamespace(client=object(), target=self))


class Later:
    """Errands whose answers the test gives."""

    def __init__(self) -> None:
        self.open: list[tuple[str, dict[str, Any], Any]] = []

    def send(self, label, port, verb, arguments, timeout, then) -> None:
        assert port == PLAYER
        self.open.append((verb, arguments, then))

    def answer(self, position: float, duration: float = 60.0) -> str:
        verb, _, then = self.open.pop(0)
        then(Outcome(verb, {"position": position, "duration": duration}, None))
        return verb


@pytest.fixture
def slider():
    return Slider(value=0.0, max=1.0, visible=True)


@pytest.fixture
def bar(slider):
    return ReplayBar(SimpleNamespace(add_slider=lambda *_, **__: slider))


def node(playing: bool):
    return SimpleNamespace(directory=SimpleNamespace(leader=lambda _: b"x" if playing else None))


def test_without_a_player_there_is_no_slider(bar, slider):
    errands = Later()
    bar.update(node(False), errands, 1.0)
    assert not slider.visible and not bar.present and not errands.open


def test_the_slider_shows_where_the_player_is(bar, slider):
    errands = Later()
    bar.update(node(True), errands, 1.0)
    assert slider.visible and errands.answer(12.5) == "status"
    assert slider.value == 12.5 and slider.max == 60.0
    bar.update(node(True), errands, 1.01)
    assert not errands.open  # it is asked twice per second only


def test_moving_the_slider_seeks_and_older_answers_do_not_move_it_back(bar, slider):
    errands = Later()
    bar.update(node(True), errands, 1.0)
    slider.move(40.0)
    bar.update(node(True), errands, 1.1)
    assert errands.open[1][:2] == ("seek", {"time": 40.0})
    errands.answer(12.5)
    assert slider.value == 40.0
    errands.answer(40.02)
    assert slider.value == 40.02


def test_what_the_page_sets_itself_is_no_request(bar, slider):
    slider.value = 3.0
    slider.callback(SimpleNamespace(client=None, target=slider))
    errands = Later()
    bar.update(node(True), errands, 1.0)
    assert [verb for verb, *_ in errands.open] == ["status"]


def test_a_player_that_does_not_answer_leaves_the_slider_alone(bar, slider):
    errands = Later()
    bar.update(node(True), errands, 1.0)
    errands.open.pop()[2](Outcome("status", None, RpcTimeout("late")))
    assert slider.value == 0.0


def test_the_status_line_begins_with_replay():
    assert status(replay=True, time=1.0).text.startswith("replay")
