"""Which limb was touched when."""

from itertools import pairwise

import pytest

from dashboard.onset_strip import BODY, GAP, PERIOD, SPAN, OnsetStrip
from robot_model.messages import Contacts

LIMBS = ("l_arm", "r_arm")


def contacts(state: str = "none", **more) -> Contacts:
    flag = {"probability": 0.5, "onset": 0, "statistic": 7.25, "threshold": 6.5} | more
    flags = [{"limb": "l_arm", "state": state, **flag}, {"limb": "r_arm", "state": "none", **flag}]
    return Contacts(flags=flags, hypotheses=[])


@pytest.fixture
def strip() -> OnsetStrip:
    return OnsetStrip(LIMBS)


def feed(strip: OnsetStrip, begin: float, end: float, said: Contacts | None) -> None:
    step = PERIOD / 4.0
    for i in range(round((end - begin) / step)):
        strip.add(begin + i * step, said)


def test_a_touch_is_a_bar_from_its_onset_to_its_end(strip):
    feed(strip, 0.0, 10.0, contacts())
    feed(strip, 10.0, 13.0, contacts("contact"))
    feed(strip, 13.0, 20.0, contacts())
    quiet, touch, after = strip.bars()["l_arm"]
    assert [bar[2] for bar in (quiet, touch, after)] == [0, 1, 0]
    assert touch[:2] == pytest.approx((-10.0, -7.0), abs=2.0 * PERIOD)
    assert [bar[2] for bar in strip.bars()["r_arm"]] == [0]


def test_a_tap_between_two_columns_is_not_missed(strip):
    feed(strip, 0.0, 5.0, contacts())
    strip.add(5.0 + 0.3 * PERIOD, contacts("collision"))
    feed(strip, 5.0 + 0.6 * PERIOD, 8.0, contacts())
    assert [bar[2] for bar in strip.bars()["l_arm"]] == [0, 2, 0]


def test_what_nobody_heard_is_no_bar(strip):
    feed(strip, 0.0, 5.0, contacts())
    feed(strip, 5.0, 10.0, None)
    feed(strip, 10.0, 11.0, contacts())
    feed(strip, 11.0 + 3.0 * GAP, 18.0, contacts())
    bars = strip.bars()["l_arm"]
    assert len(bars) == 3
    assert all(before[1] < after[0] for before, after in pairwise(bars))
    assert strip.bars()[BODY] == []


def test_only_the_last_minute_is_shown(strip):
    feed(strip, 0.0, 5.0, contacts("contact"))
    feed(strip, 5.0, 5.0 + SPAN + 2.0, contacts())
    ((begin, end, level),) = strip.bars()["l_arm"]
    assert level == 0 and -SPAN <= begin < end <= 0.0


def test_a_clock_that_was_reset_begins_anew(strip):
    feed(strip, 50.0, 55.0, contacts("contact"))
    feed(strip, 0.0, 5.0, contacts())
    assert [bar[2] for bar in strip.bars()["l_arm"]] == [0]


def test_flags_of_now_stand_at_the_right_with_their_thresholds(strip):
    said = contacts("contact")
    whole = {"state": "contact", "probability": 0.9, "onset": 5, "statistic": 9.0, "threshold": 4.0}
    strip.add(1.0, said)
    html = strip.html(Contacts(flags=said.flags, hypotheses=[], body=whole))
    assert "contact</b> 7.2 / 6.5" in html and "contact</b> 9.0 / 4.0" in html
    assert "unknown" in strip.html(None)


def test_limb_that_is_not_judged_has_no_bar_and_says_why(strip):
    said = contacts(valid=False, reason="the foot stands")
    feed(strip, 0.0, 5.0, said)
    assert strip.bars()["l_arm"] == []
    assert 'title="the foot stands">not judged<' in strip.html(said)
