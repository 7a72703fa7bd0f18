"""One unknown wrench per sub-tree: which contact each sub-tree gets."""

import numpy as np
import pytest

from estimation.contact_set import contact_set
from robot_model import load_robot


@pytest.fixture(scope="module")
def robot():
    return load_robot("icub")


def test_supports_are_known_and_the_rest_is_assumed(robot):
    kinds = {c.frame: c.kind for c in contact_set(robot, "floor")}
    assert kinds["l_sole"] == kinds["r_sole"] == "support"
    assert set(kinds.values()) == {"support", "default"}


def test_the_pole_takes_the_place_of_the_roots_default_contact(robot):
    first = contact_set(robot, "pole")[0]
    assert (first.frame, first.kind) == ("root_link", "support")


def test_without_support_the_soles_are_ordinary_contacts(robot):
    assert {c.kind for c in contact_set(robot, "none")} == {"default"}


def test_a_touch_replaces_the_default_of_its_own_subtree_only(robot):
    before = contact_set(robot, "floor")
    after = contact_set(robot, "floor", [("l_forearm", np.array([0.0, 0.0, 0.05]))])
    changed = [i for i, (a, b) in enumerate(zip(before, after, strict=True)) if a.frame != b.frame]
    assert changed == [robot.subtree_of("l_forearm")]
    assert after[changed[0]].kind == "touch"


@pytest.mark.parametrize(
    ("touches", "text"),
    [
        ([("l_foot", np.zeros(3))], "cannot be told from the support at 'l_sole'"),
        ([("l_hand", np.zeros(3)), ("l_forearm", np.zeros(3))], "'l_hand' and 'l_forearm'"),
        ([("l_hand", np.array([0.0, np.nan, 0.0]))], "three finite numbers"),
        ([("l_hand", np.zeros(2))], "three finite numbers"),
    ],
)
def test_undecidable_and_meaningless_points_are_refused(robot, touches, text):
    with pytest.raises(ValueError, match=text):
        contact_set(robot, "floor", touches)


def test_unknown_names_are_refused_with_what_exists(robot):
    with pytest.raises(LookupError, match="did you mean 'l_forearm'"):
        contact_set(robot, "floor", [("l_forarm", np.zeros(3))])
    with pytest.raises(LookupError, match="floor, pole"):
        contact_set(robot, "flor")
