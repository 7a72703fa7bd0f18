"""Thresholds and gains from the page."""

from types import SimpleNamespace
from typing import Any

import pytest

from bus import RpcError
from dashboard.errands import Outcome
from dashboard.html import RED
from dashboard.tuning import DETECTOR, Tuning


class Detector:
    """Errands to a detector that has two of the settings; answers wait until ``answer``."""

    def __init__(self) -> None:
        self.there, self.silent = True, False
        self.values: dict[str, Any] = {
            "levels.contact": 6.5,
            "model_error": 0.02,
            "support": "pole",
        }
        self.asked: list[dict[str, Any]] = []
        self.directory = SimpleNamespace(leader=lambda port: "x" if self.there else None)
        self._open: list[Any] = []

    def send(self, label, port, verb, request, timeout, then) -> None:
        assert (port, verb) == (DETECTOR, "param")
        self.asked.append(request)
        self._open.append((request, then))

    def answer(self) -> None:
        for request, then in self._open:
            outcome = self._outcome(**request)
            failed = isinstance(outcome, Exception)
            then(Outcome("", None if failed else outcome, outcome if failed else None))
        self._open = []

    def _outcome(self, action: str, name: str = "", value: Any = 0.0) -> Any:
        if self.silent:
            return RpcError("no answer within 2 s")
        if action == "list":
            return dict(self.values)
        if action == "save":
            return {"file": "/state/x.yaml", "message": "saved in /state/x.yaml"}
        if isinstance(value, float) and value < 0.0:
            return RpcError("levels.contact: must be positive")
        self.values[name] = 6.5 if action == "reset" else value
        return self.values[name]


@pytest.fixture
def tuning(server):
    return Tuning(server.gui)


@pytest.fixture
def detector():
    return Detector()


@pytest.fixture
def step(tuning, detector):
    """A look of the page's loop, a second after the one before."""
    moments = iter(range(1, 100))

    def look() -> None:
        tuning.update(detector, detector, float(next(moments)))
        detector.answer()

    return look


def move(tuning: Tuning, name: str, value: float | str, client: Any = "browser") -> None:
    target = SimpleNamespace(value=value)
    tuning._moved(name, SimpleNamespace(client=client, target=target))


def test_sliders_show_what_is_in_force_and_only_what_there_is(tuning, step):
    step()
    shown = {name: widget.value for name, widget in tuning._widgets.items() if widget.visible}
    assert shown == {"levels.contact": 6.5, "model_error": 0.02}


def test_moving_a_slider_sets_the_newest_value_once(tuning, detector, step):
    step()
    move(tuning, "levels.contact", 7.0)
    move(tuning, "levels.contact", 8.0)
    step()
    assert detector.asked[1:] == [{"action": "set", "name": "levels.contact", "value": 8.0}]
    assert "levels.contact = 8.0" in tuning._said.content


def test_what_the_page_itself_shows_is_not_sent_back(tuning, detector, step):
    move(tuning, "levels.contact", 7.0, client=None)
    step()
    assert [request["action"] for request in detector.asked] == ["list"]


def test_refused_value_is_told_and_the_slider_returns(tuning, detector, step):
    step()
    tuning._widgets["levels.contact"].value = 3.0
    move(tuning, "levels.contact", -1.0)
    step()
    assert "must be positive" in tuning._said.content and RED in tuning._said.content
    step()
    assert tuning._widgets["levels.contact"].value == 6.5


def test_value_set_elsewhere_is_followed_beyond_the_sliders_range(tuning, detector, step):
    detector.values["levels.contact"] = 99.0
    step()
    slider = tuning._widgets["levels.contact"]
    assert (slider.value, slider.max) == (99.0, 99.0)


def test_method_of_locating_is_a_choice(tuning, detector, step):
    detector.values["method"] = "line"
    step()
    assert tuning._widgets["method"].visible and tuning._widgets["method"].value == "line"
    move(tuning, "method", "particle")
    step()
    assert detector.values["method"] == "particle"


def test_reset_and_save_are_the_detectors_own(tuning, detector, step):
    step()
    tuning._reset()
    step()
    assert [r["name"] for r in detector.asked[1:]] == ["levels.contact", "model_error"]
    assert {r["action"] for r in detector.asked[1:]} == {"reset"}
    tuning._requests.append({"action": "save"})
    step()
    assert "saved in /state/x.yaml" in tuning._said.content


def test_detector_that_does_not_answer_is_told_until_it_does(tuning, detector, step):
    step()
    move(tuning, "levels.contact", 8.0)
    step()
    detector.silent = True
    step()
    assert "no answer" in tuning._state.content and "levels.contact = 8.0" in tuning._said.content
    assert tuning._widgets["levels.contact"].visible
    detector.silent = False
    step()
    assert "no answer" not in tuning._state.content


def test_without_a_detector_nothing_is_asked(tuning, detector, step):
    detector.there = False
    move(tuning, "levels.contact", 7.0)
    step()
    assert not detector.asked and "no contact detector" in tuning._state.content
