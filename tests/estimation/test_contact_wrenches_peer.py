"""Contacts of mixed kinds beside iDynTree, where six unknowns or fewer are unique.

With more unknowns iDynTree gives a basic solution that depends on the order of the
contacts, so there the closed form is the reference.
"""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np
import pinocchio as pin
import pytest

from benchmarks.idyntree_observer import IdyntreeObserver, idyn
from estimation.contact_wrenches import (
    ContactUnknown,
    Units,
    contact_wrenches,
    force_along,
    full_wrench,
    known_wrench,
    pure_force,
)
from estimation.torque_observer import TorqueObserver
from robot_model import Robot, load_robot
from tests.estimation.observer_states import random_input
from tests.estimation.test_contact_wrenches import closed_form

STATES = 250  # on each of two robots
SKIN = np.array([1.0, -2.0, 0.5, 0.1, 0.0, -0.2])


class Place(NamedTuple):
    """A contact on a link, as both understand it."""

    link: str
    point: tuple[float, float, float]
    kind: str  # full, force, along or known
    direction: tuple[float, float, float] = (0.0, 0.0, 1.0)


class MixedContacts(IdyntreeObserver):
    """The peer with contacts of any kind on one sub-tree, and full wrenches elsewhere."""

    def __init__(self, robot: Robot, frames: Sequence[str], places: Sequence[Place]):
        self._places = places
        super().__init__(robot, frames)

    def _add_contacts(self, model, frames):
        super()._add_contacts(model, frames)
        kinds = {
            "full": idyn.FULL_WRENCH,
            "force": idyn.PURE_FORCE,
            "along": idyn.PURE_FORCE_WITH_KNOWN_DIRECTION,
            "known": idyn.NO_UNKNOWNS,
        }
        for place in self._places:
            contact = idyn.UnknownWrenchContact()
            contact.unknownType = kinds[place.kind]
            contact.contactPoint = idyn.Position(*place.point)
            contact.forceDirection = idyn.Direction(*place.direction)
            contact.knownWrench = idyn.Wrench.FromPython(SKIN)
            self._unknowns.addNewContactForLink(model.getLinkIndex(place.link), contact)
        self._model = model

    def placed(self) -> np.ndarray:
        """Wrenches of the places, (c, 6) about their points in link axes."""
        seen: dict[str, int] = {}
        rows = []
        for place in self._places:
            index = seen[place.link] = seen.get(place.link, -1) + 1
            wrench = self._wrenches.contactWrench(self._model.getLinkIndex(place.link), index)
            rows.append(wrench.contactWrench.toNumPy())
        return np.array(rows)


def contact_of(place: Place, body_m_link: pin.SE3) -> ContactUnknown:
    placement = body_m_link * pin.SE3(np.eye(3), np.array(place.point))
    if place.kind == "along":
        return force_along(placement, np.array(place.direction))
    if place.kind == "known":
        return known_wrench(placement, SKIN)
    return full_wrench(placement) if place.kind == "full" else pure_force(placement)


def placements(robot: Robot, q: np.ndarray, base: str, links: Sequence[str]) -> list[pin.SE3]:
    """Placements of links in the frame ``base`` at a posture."""
    model, data = robot.tree.model, robot.tree.model.createData()
    pin.framesForwardKinematics(model, data, robot.tree.configuration(q))
    world_m_base = data.oMf[robot.tree.frame_id(base)]
    return [world_m_base.actInv(data.oMf[robot.tree.frame_id(link)]) for link in links]


MIXES = {
    "one full wrench": [Place("l_forearm", (0.0, 0.01, -0.05), "full")],
    "full wrench and skin": [
        Place("l_forearm", (0.0, 0.01, -0.05), "full"),
        # The peer takes the moment of a known wrench about the link's origin.
        Place("l_hand", (0.0, 0.0, 0.0), "known"),
    ],
    "force and three directions": [
        Place("l_hand", (0.01, 0.0, 0.02), "force"),
        Place("l_forearm", (0.0, 0.04, -0.05), "along", (1.0, 0.0, 0.0)),
        Place("l_forearm", (0.03, 0.0, 0.02), "along", (0.0, 1.0, 0.0)),
        Place("l_upper_arm", (0.0, 0.03, -0.05), "along", (0.6, 0.0, 0.8)),
    ],
    "six directions": [
        Place("l_hand", (0.01, 0.0, 0.02), "along", (1.0, 0.0, 0.0)),
        Place("l_hand", (0.01, 0.02, 0.02), "along", (0.0, 1.0, 0.0)),
        Place("l_hand", (0.04, 0.0, 0.0), "along", (0.0, 0.0, 1.0)),
        Place("l_forearm", (0.0, 0.04, -0.05), "along", (1.0, 0.0, 0.0)),
        Place("l_forearm", (0.03, 0.0, 0.02), "along", (0.0, 1.0, 0.0)),
        Place("l_upper_arm", (0.0, 0.03, -0.05), "along", (0.0, 0.6, 0.8)),
    ],
}


def on_links_of(robot: Robot, places: Sequence[Place]) -> list[Place]:
    """Places on links that remain where the wrist is locked."""
    if "l_hand" in robot.links:
        return list(places)
    nearest = {"l_hand": "l_elbow_1", "l_forearm": "l_upper_arm"}
    return [place._replace(link=nearest.get(place.link, place.link)) for place in places]


@pytest.mark.parametrize("mix", MIXES)
def test_mixed_contacts_of_an_arm_equal_idyntrees(mix, peer_robot):
    robot = peer_robot
    places = on_links_of(robot, MIXES[mix])
    observer = TorqueObserver(robot)
    arm = robot.subtree_of("l_hand")
    elsewhere = [c.frame for c in observer.contacts if c.subtree != arm]
    peer = MixedContacts(robot, elsewhere, places)
    rng = np.random.default_rng(5)
    default = robot.subtrees[arm].default_frame
    for _ in range(STATES):
        state = random_input(robot, rng)
        peer.step(*state._replace(ft=-state.ft))
        links = placements(robot, state.q, default, [place.link for place in places])
        system = contact_wrenches([contact_of(p, m) for p, m in zip(places, links, strict=True)])
        assert (system.unknowns, system.rank) == (6, 6)
        ours = system.solve(observer.step(*state).subtree_wrench[arm])
        theirs = peer.placed()
        scale = max(1.0, np.abs(theirs).max())
        np.testing.assert_allclose(ours.wrench / scale, theirs / scale, rtol=0.0, atol=1e-9)


def test_fewer_unknowns_that_explain_the_net_wrench_equal_idyntrees():
    robot, rng = load_robot("icub"), np.random.default_rng(6)
    observer = TorqueObserver(robot)
    arm = robot.subtree_of("l_hand")
    default = robot.subtrees[arm].default_frame
    places = [
        Place("l_hand", (0.01, 0.0, 0.02), "force"),
        Place("l_forearm", (0.0, 0.04, -0.05), "along", (1.0, 0.0, 0.0)),
    ]
    elsewhere = [c.frame for c in observer.contacts if c.subtree != arm]
    peer = MixedContacts(robot, elsewhere, places)
    state = random_input(robot, rng)
    wrenches = np.zeros((2, 6))
    wrenches[0, :3], wrenches[1, 0] = [3.0, -4.0, 5.0], 6.0
    links = placements(robot, state.q, default, [place.link for place in places])
    contacts = [contact_of(p, m) for p, m in zip(places, links, strict=True)]
    net = sum(c.placement.act(pin.Force(w)).vector for c, w in zip(contacts, wrenches, strict=True))
    state = state._replace(ft=reading_with(observer, state, arm, net))
    peer.step(*state._replace(ft=-state.ft))
    shared = contact_wrenches(contacts).solve(observer.step(*state).subtree_wrench[arm])
    np.testing.assert_allclose(shared.wrench, wrenches, atol=1e-9)
    np.testing.assert_allclose(peer.placed(), wrenches, atol=1e-9)


TOO_MANY = {
    "two full wrenches": ["full", "full"],
    "full wrench and force": ["full", "force"],
    "three forces": ["force", "force", "force"],
}
POINTS = [
    ("l_hand", (0.01, 0.0, 0.02)),
    ("l_forearm", (0.0, 0.04, -0.05)),
    ("l_upper_arm", (0.0, 0.03, -0.05)),
]


@pytest.mark.parametrize("kinds", TOO_MANY)
def test_with_too_many_unknowns_the_answer_is_the_closed_form_in_any_order(kinds, peer_robot):
    robot, rng = peer_robot, np.random.default_rng(8)
    observer = TorqueObserver(robot)
    subtree = robot.subtrees[robot.subtree_of("l_hand")]
    named = zip(POINTS, TOO_MANY[kinds], strict=False)
    places = on_links_of(robot, [Place(link, point, kind) for (link, point), kind in named])
    for _ in range(STATES):
        state = random_input(robot, rng)
        links = placements(robot, state.q, subtree.default_frame, [p.link for p in places])
        contacts = [contact_of(p, m) for p, m in zip(places, links, strict=True)]
        net = observer.step(*state).subtree_wrench[subtree.ft_in + 1]
        system = contact_wrenches(contacts)
        assert system.rank == 6 < system.unknowns
        ours = system.solve(net).wrench
        scale = max(1.0, np.abs(ours).max())
        closed = closed_form(contacts, net, Units())
        np.testing.assert_allclose(ours / scale, closed / scale, rtol=0.0, atol=1e-9)
        turned = contact_wrenches(contacts[::-1]).solve(net).wrench[::-1]
        np.testing.assert_allclose(ours / scale, turned / scale, rtol=0.0, atol=1e-9)


def test_with_too_many_unknowns_idyntrees_answer_is_ours_and_undecided_patterns():
    robot, rng = load_robot("icub"), np.random.default_rng(7)
    observer = TorqueObserver(robot)
    arm = robot.subtree_of("l_hand")
    places = [
        Place("l_hand", (0.01, 0.0, 0.02), "full"),
        Place("l_forearm", (0.0, 0.04, -0.05), "full"),
    ]
    elsewhere = [c.frame for c in observer.contacts if c.subtree != arm]
    peer = MixedContacts(robot, elsewhere, places)
    state = random_input(robot, rng)
    peer.step(*state._replace(ft=-state.ft))
    frame = robot.subtrees[arm].default_frame
    links = placements(robot, state.q, frame, [place.link for place in places])
    system = contact_wrenches([contact_of(p, m) for p, m in zip(places, links, strict=True)])
    ours = system.solve(observer.step(*state).subtree_wrench[arm]).wrench / Units().wrench
    theirs = peer.placed() / Units().wrench
    patterns = (system.undecided / Units().wrench).reshape(-1, 12)
    difference = (theirs - ours).ravel()
    np.testing.assert_allclose(patterns.T @ (patterns @ difference), difference, atol=1e-8)
    assert np.linalg.norm(ours) <= np.linalg.norm(theirs)


def reading_with(observer: TorqueObserver, state, arm: int, net: np.ndarray) -> np.ndarray:
    """Readings with which a sub-tree's net wrench is ``net`` and the others' are any."""
    ft, sensor = state.ft.copy(), observer.robot.subtrees[arm].ft_in
    start = observer.step(*state).subtree_wrench[arm]
    columns = []
    for axis in np.eye(6):
        moved = ft.copy()
        moved[sensor] += axis
        columns.append(observer.step(*state._replace(ft=moved)).subtree_wrench[arm] - start)
    ft[sensor] += np.linalg.solve(np.array(columns).T, net - start)
    return ft
