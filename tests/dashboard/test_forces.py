from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from dashboard.forces import Force, estimated_forces, segments, true_forces

UP = np.array([0.0, 0.0, 1.0])


def wrenches(**changes: Any) -> Any:
    values = {
        "frame": ["l_sole", "l_hand"],
        "link": ["l_foot", "l_hand"],
        "point": np.zeros((2, 3)),
        "wrench": np.array([[0, 0, 150.0, 0, 0, 0], [0, 0, 12.0, 0, 0, 0]]),
        "valid": np.array([True, True]),
        "kind": ["support", "default"],
        "decided": [],
    }
    return SimpleNamespace(**(values | changes))


def test_estimated_force_is_turned_from_its_frame_into_the_world(placement):
    hand = estimated_forces(wrenches(), placement)[1]
    assert hand.force == pytest.approx(placement.vector("l_hand", 12.0 * UP))
    assert hand.point == pytest.approx(placement.point("l_hand", np.zeros(3)))


def test_invalid_wrench_is_not_drawn(placement):
    forces = estimated_forces(wrenches(valid=np.array([True, False])), placement)
    assert [force.support for force in forces] == [True]


def test_tip_of_the_arrow_is_the_point_and_its_length_the_scaled_force():
    force = Force(np.array([1.0, 2.0, 3.0]), 10.0 * UP, support=False)
    (tail, tip) = segments([force], scale=0.01, hide_below=1.0)[0]
    assert tip == pytest.approx([1.0, 2.0, 3.0])
    assert tip - tail == pytest.approx([0.0, 0.0, 0.1])


def test_small_forces_are_left_out():
    forces = [Force(np.zeros(3), 0.5 * UP, False), Force(np.zeros(3), 50.0 * UP, False)]
    assert segments(forces, scale=0.01, hide_below=1.0).shape == (1, 2, 3)


def test_contact_that_the_data_leave_open_is_marked(placement):
    marked = estimated_forces(wrenches(decided=[True, False]), placement)
    assert [force.decided for force in marked] == [True, False]
    assert all(force.decided for force in estimated_forces(wrenches(), placement))


def test_true_push_keeps_its_world_axes_and_support_force_is_turned(placement):
    truth: Any = SimpleNamespace(
        pushes=[{"id": 1, "link": "l_forearm", "point": [0, 0, 0], "force_world": [1, 2, 3]}],
        support_frames=["l_sole"],
        support_wrench=np.array([[0, 0, 150.0, 0, 0, 0]]),
    )
    push, support = true_forces(truth, placement)
    assert push.force == pytest.approx([1, 2, 3]) and not push.support
    assert support.force == pytest.approx(placement.vector("l_sole", 150.0 * UP))
