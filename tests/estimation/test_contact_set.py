"""Which contacts each sub-tree gets."""

import numpy as np
import pytest

from estimation.contact_set import MOST, Touch, contact_set, net_contacts, shared_subtrees


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
        ([("l_hand", np.array([0.0, np.nan, 0.0]))], "three finite numbers"),
        ([("l_hand", np.zeros(2))], "three finite numbers"),
        ([Touch("l_hand", np.zeros(3), "direction")], "zero"),
        ([Touch("l_hand", np.zeros(3), "direction", np.ones(2))], "expected 3 numbers, got 2"),
        ([Touch("l_hand", np.zeros(3), "known", np.ones(3))], "expected 6 numbers, got 3"),
        ([Touch("l_foot", np.zeros(3), "none")], "touched at 'l_sole'"),
        ([Touch("l_hand", np.zeros(3), "none"), ("l_forearm", np.zeros(3))], "at 'l_forearm'"),
        ([("l_hand", np.zeros(3))] * (MOST + 1), f"at most {MOST}"),
    ],
)
def test_meaningless_touches_are_refused(robot, touches, text):
    with pytest.raises(ValueError, match=text):
        contact_set(robot, "floor", touches)


def test_several_touches_share_a_subtree_and_leave_the_others_alone(robot):
    touches = [("l_hand", np.zeros(3)), Touch("l_forearm", np.zeros(3), "force")]
    contacts = contact_set(robot, "floor", touches)
    arm = robot.subtree_of("l_hand")
    assert len(contacts) == len(robot.subtrees) + 1
    assert [c.frame for c in contacts if c.subtree == arm] == ["l_hand", "l_forearm"]
    assert list(shared_subtrees(robot, contacts)) == [arm]
    assert net_contacts(robot, contacts)[arm].frame == "l_hand"


def test_a_touch_on_a_supporting_subtree_comes_beside_the_support(robot):
    contacts = contact_set(robot, "floor", [("l_foot", np.zeros(3))])
    foot = [c for c in contacts if c.subtree == robot.subtree_of("l_foot")]
    assert [c.kind for c in foot] == ["support", "touch"]


def test_an_untouched_subtree_has_no_contact(robot):
    contacts = contact_set(robot, "floor", [Touch("l_hand", np.zeros(3), "none")])
    arm = robot.subtree_of("l_hand")
    assert arm not in {c.subtree for c in contacts}
    assert shared_subtrees(robot, contacts) == {arm: ()}
    assert net_contacts(robot, contacts)[arm].frame == robot.subtrees[arm].default_frame


def test_unknown_names_are_refused_with_what_exists(robot):
    with pytest.raises(LookupError, match="did you mean 'l_forearm'"):
        contact_set(robot, "floor", [("l_forarm", np.zeros(3))])
    with pytest.raises(LookupError, match="there are: wrench, force, direction, known, none"):
        contact_set(robot, "floor", [Touch("l_hand", np.zeros(3), "push")])
    with pytest.raises(LookupError, match="floor, pole"):
        contact_set(robot, "flor")
