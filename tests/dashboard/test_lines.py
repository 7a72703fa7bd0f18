"""The texts that INTERFACES pins."""

import numpy as np
import pytest

from dashboard.last_contact import LastContact
from dashboard.status import status
from dashboard.touches import Alarm, alarm, touches
from robot_model.messages import Contacts

QUIET = {"limb": "r_arm", "state": "none", "probability": 0.02, "onset": 0}
TOUCHED = {"limb": "l_arm", "state": "contact", "probability": 0.97, "onset": 5, "force": 11.96}
GUESS = {
    "links": ["l_forearm", "l_elbow_1"],
    "point": [0.0, 0.0, 0.1],
    "force": [0.0, 3.0, 4.0],
    "probability": 0.934,
}


def contacts(*flags, hypotheses=()):
    return Contacts(flags=list(flags), hypotheses=list(hypotheses))


def test_alarm_line_without_contact():
    assert alarm(contacts(QUIET), "", {}).text == "no contact"


def test_alarm_line_names_link_force_and_probability_of_the_best_hypothesis():
    said = alarm(contacts(QUIET, TOUCHED, hypotheses=[GUESS]), "", {})
    assert said.text == "contact: l_forearm 5.0 N p=0.93"
    assert said.contact


def test_alarm_line_names_the_limbs_default_link_until_there_is_a_hypothesis():
    said = alarm(contacts(QUIET, TOUCHED), "", {"l_arm": "l_hand"})
    assert said.text == "contact: l_hand 12.0 N p=0.97"


def test_hypotheses_alone_are_no_contact():
    assert alarm(contacts(QUIET, hypotheses=[GUESS]), "", {}).text == "no contact"


def test_silent_detector_is_never_mistaken_for_no_contact():
    said = alarm(None, "no data on /icub/contacts:o for 50 ms", {})
    assert said.text == "contact unknown: no data on /icub/contacts:o for 50 ms"
    assert not said.contact


def test_collision_has_another_colour_than_contact():
    collision = TOUCHED | {"state": "collision"}
    assert alarm(contacts(collision), "", {}).colour != alarm(contacts(TOUCHED), "", {}).colour


def test_hypothesis_is_placed_by_the_frame_of_its_first_link(placement):
    (touch,) = touches(contacts(TOUCHED, hypotheses=[GUESS]), placement)
    assert touch.point == pytest.approx(placement.point("l_forearm", np.array(GUESS["point"])))
    assert touch.force == pytest.approx(placement.vector("l_forearm", np.array(GUESS["force"])))
    assert touch.label == "l_forearm 5.0 N p=0.93"


@pytest.mark.parametrize(
    ("word", "state"),
    [
        ("live", {"time": 1.0}),
        ("live", {"holding": True}),
        ("live", {"fallen": True}),
        ("replay", {"replay": True}),
        ("stale", {"stale": "no data", "replay": True, "holding": True}),
        ("paused", {"paused": True, "stale": "no data"}),
        ("paused", {"frozen": True}),
    ],
)
def test_status_line_begins_with_its_word(word, state):
    assert status(**state).text.startswith(word)


def test_status_line_says_why_it_is_stale():
    assert status(stale="nobody writes /icub/base:o").text == "stale: nobody writes /icub/base:o"


def reading(probability: float) -> Alarm:
    return Alarm(f"contact: l_forearm 5.0 N p={probability:.2f}", "", probability)


def test_last_contact_is_its_most_probable_reading():
    last = LastContact()
    for now, probability in ((0.0, 0.4), (0.2, 0.9), (0.4, 0.6)):
        last.note(reading(probability), now)
    last.note(Alarm("no contact", ""), 0.6)
    assert last.text(3.4) == "last contact: l_forearm 5.0 N p=0.90, 3 s ago"


def test_new_contact_replaces_a_more_probable_one_of_before():
    last = LastContact()
    last.note(reading(0.9), 0.0)
    last.note(reading(0.4), 2.0)
    assert last.text(2.0) == "last contact: l_forearm 5.0 N p=0.40, 0 s ago"
