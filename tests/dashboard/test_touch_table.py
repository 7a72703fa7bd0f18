"""The ranked list of where a touch may be."""

import numpy as np
import pytest

from dashboard.touch_table import SHOWN, largest_deviation, touch_table
from robot_model.messages import Contacts

BEST = {
    "links": ["l_forearm", "l_elbow_1"],
    "point": [0.012, -0.03, 0.1401],
    "force": [0.0, 3.0, 4.0],
    "covariance": np.diag([4e-6, 9e-6, 1e-6, 0.04, 0.01, 0.25]).tolist(),
    "probability": 0.934,
}


def text(contacts: Contacts | None) -> str:
    return " ".join(touch_table(contacts).replace(">", "> ").replace("<", " <").split())


def test_list_has_links_probability_force_point_and_their_spread():
    said = text(Contacts(flags=[], hypotheses=[BEST], none_probability=0.066))
    cells = ("l_forearm or l_elbow_1", "0.93", "5.0", "0.5", "12 -30 140", "3")
    assert all(f"> {cell} <" in said for cell in cells)
    assert "none of these" in said and "> 0.07 <" in said


def test_list_has_only_the_best():
    many = [BEST | {"links": [f"link_{i}"]} for i in range(SHOWN + 3)]
    said = text(Contacts(flags=[], hypotheses=many))
    assert f"link_{SHOWN - 1} " in said and f"link_{SHOWN} " not in said


def test_list_leaves_out_what_is_out_of_the_question():
    faint = BEST | {"links": ["l_hand"], "probability": 0.001}
    said = text(Contacts(flags=[], hypotheses=[BEST, faint]))
    assert "l_forearm" in said and "l_hand" not in said


def test_without_a_hypothesis_there_is_no_list():
    assert text(None) == text(Contacts(flags=[], hypotheses=[])) == ""


def test_spread_is_that_along_the_worst_direction():
    turn = np.linalg.qr(np.arange(9.0).reshape(3, 3) + np.eye(3))[0]
    covariance = turn @ np.diag([1.0, 4.0, 9.0]) @ turn.T
    assert largest_deviation(covariance) == pytest.approx(3.0)
    assert largest_deviation(np.zeros((3, 3))) == 0.0
