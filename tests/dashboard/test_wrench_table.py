"""The list of wrenches."""

from typing import Any

import numpy as np

from dashboard.wrench_table import wrench_table
from robot_model.messages import ExternalWrenches


def wrenches(**changes: Any) -> ExternalWrenches:
    values: dict[str, Any] = {
        "frame": ["l_hand", "l_forearm", "r_hand"],
        "link": ["l_hand", "l_forearm", "r_hand"],
        "subtree": ["l_arm", "l_arm", "r_arm"],
        "point": np.zeros((3, 3)),
        "wrench": np.tile([3.0, 0.0, 4.0, 0.0, 0.25, 0.0], (3, 1)),
        "covariance": np.tile(np.diag([0.04, 0.01, 0.01, 1e-4, 4e-4, 1e-4]), (3, 1, 1)),
        "valid": np.ones(3, dtype=bool),
        "kind": ["default"] * 3,
        "subtree_wrench": np.zeros((3, 6)),
        "subtree_valid": np.ones(3, dtype=bool),
    }
    return ExternalWrenches(**(values | changes))


def shown(said: ExternalWrenches | None) -> str:
    return wrench_table(said, ("trunk", "l_arm", "r_arm"))


def test_force_and_moment_come_with_their_spread():
    text = shown(wrenches())
    for cell in (">l_hand<", ">5.0<", ">0.2<", ">0.25<", ">0.02<"):
        assert cell in text
    assert "undecided" not in text


def test_what_the_sensors_leave_open_is_named():
    text = shown(wrenches(decided=[False, False, True]))
    assert "undecided: l_hand, l_forearm<" in text


def test_a_wrench_that_is_not_valid_is_no_number_and_says_why():
    lost = np.array([True, True, False])
    reasons = ["", "", "r_arm_ft <silent>"]
    text = shown(wrenches(valid=lost, subtree_reasons=reasons, decided=[True, True, False]))
    assert text.count(">--<") == 4 and text.count("r_arm_ft &lt;silent&gt;") == 5
    assert "undecided" not in text  # of an invalid one nothing is said


def test_without_wrenches_there_is_no_list():
    assert shown(None) == ""
