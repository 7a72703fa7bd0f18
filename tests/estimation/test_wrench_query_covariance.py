"""The covariance of any wrench: as published, moved, and against sampled noise."""

from dataclasses import replace

import numpy as np
import pinocchio as pin
import pytest

from estimation.contact_set import Touch
from estimation.observer_covariance import propagate
from estimation.torque_observer import TorqueObserver
from estimation.wrench_query import WrenchQuery
from tests.estimation.observer_noise import NOISE, noisy, off
from tests.estimation.observer_states import random_input

SQUEEZED = [Touch("l_hand", np.zeros(3), "force"), Touch("l_forearm", np.array([0.0, 0.02, 0.05]))]
SOURCE = np.diag([0.01, 0.02, 0.03, 0.1, 0.2, 0.3]) + 0.005


@pytest.fixture(scope="module")
def state(robot):
    return random_input(robot, np.random.default_rng(4))


@pytest.fixture(params=["one contact per sub-tree", "two on the left arm"])
def observer(robot, request):
    observer = TorqueObserver(robot)
    observer.set_contacts(SQUEEZED if "two" in request.param else ())
    return observer


@pytest.fixture(params=[None, SOURCE], ids=["first sensor", "fusion"])
def source(request):
    return request.param


def test_contacts_and_subtrees_have_the_published_covariance(robot, observer, state, source):
    published = propagate(observer, NOISE, *state[:3], *state[4:], source=source)
    query = WrenchQuery(observer, NOISE, *state, source=source)
    for contact, covariance in zip(observer.contacts, published.wrench, strict=True):
        about = contact.link, contact.frame, contact.point
        told = query.wrench(f"contact:{contact.frame}", *about).covariance
        np.testing.assert_allclose(told, covariance, rtol=1e-9, atol=1e-12)
    for subtree, covariance in zip(robot.subtrees, published.subtree_wrench, strict=True):
        told = query.wrench(f"subtree:{subtree.name}").covariance
        np.testing.assert_allclose(told, covariance, rtol=1e-9, atol=1e-12)


def test_readings_are_as_uncertain_as_the_sensors(robot, observer, state):
    told = WrenchQuery(observer, NOISE, *state).wrench(f"sensor:{robot.ft_sensors[0]}")
    np.testing.assert_allclose(told.covariance, np.diag(NOISE.reading**2), atol=1e-15)


@pytest.mark.parametrize(
    "of",
    ["contact:l_sole", "subtree:l_arm", "sensor:r_arm_ft", "joint:r_knee", "link:chest"],
)
def test_in_another_frame_the_covariance_follows_the_wrench(robot, observer, state, of):
    query, point = WrenchQuery(observer, NOISE, *state), np.array([0.1, -0.2, 0.3])
    own = query.wrench(of)
    moved = query.wrench(of, "l_hand", axes="head", point=point)
    model, data = robot.tree.model, robot.tree.model.createData()
    pin.framesForwardKinematics(model, data, robot.tree.configuration(state.q))
    place, hand, head = (data.oMf[robot.tree.frame_id(f)] for f in (own.frame, "l_hand", "head"))
    asked = pin.SE3(head.rotation, (hand * pin.SE3(np.eye(3), point)).translation)
    to = (asked.inverse() * place).toDualActionMatrix()
    np.testing.assert_allclose(moved.wrench, to @ own.wrench, atol=1e-9)
    np.testing.assert_allclose(moved.covariance, to @ own.covariance @ to.T, rtol=1e-9, atol=1e-9)


def test_along_its_axis_a_joint_is_as_uncertain_as_its_torque(robot, observer, state, source):
    published = propagate(observer, NOISE, *state[:3], *state[4:], source=source)
    query = WrenchQuery(observer, NOISE, *state, source=source)
    axes = {joint.name: joint.axis for joint in robot.urdf.joints.values()}
    for name, std in zip(robot.joints, published.torque_std, strict=True):
        moment = query.wrench(f"joint:{name}").covariance[3:, 3:]
        assert np.sqrt(axes[name] @ moment @ axes[name]) == pytest.approx(std, rel=1e-9)


def test_joints_and_links_scatter_as_stated(robot, state, monkeypatch):
    """Each entry of the covariance, as a share of the two standard deviations."""
    observer = TorqueObserver(robot)
    observer.set_contacts(SQUEEZED)  # l_wrist_pitch lies between the two
    joints = ("neck_yaw", "torso_pitch", "l_wrist_pitch", "l_elbow", "r_knee")
    links = {name: robot.urdf.links[name] for name in ("l_forearm", "chest", "r_foot")}
    asked = [f"joint:{name}" for name in joints] + [f"link:{name}" for name in links]
    told = [WrenchQuery(observer, NOISE, *state).wrench(of) for of in asked]
    rng, wrenches = np.random.default_rng(0), []
    for sample in noisy(observer, state, 300):
        for name, link in links.items():
            wrong = replace(link, inertia=off(link.inertia, rng))
            monkeypatch.setitem(robot.urdf.links, name, wrong)
        query = WrenchQuery(observer, NOISE, *sample)
        wrenches.append([query.wrench(of).wrench for of in asked])
    for (wrench, _, covariance, _), scattered in zip(
        told, np.swapaxes(wrenches, 0, 1), strict=True
    ):
        missed, std = scattered - wrench, np.sqrt(np.diag(covariance))
        scatter = missed.T @ missed / len(missed)
        np.testing.assert_allclose((scatter - covariance) / np.outer(std, std), 0.0, atol=0.25)


def test_what_the_sensors_leave_undecided_is_told(robot, state):
    """Hand and forearm may push against each other: so the joint between them bears any of it."""
    observer = TorqueObserver(robot)
    observer.set_contacts(SQUEEZED)
    query = WrenchQuery(observer, NOISE, *state)
    hand, forearm = (query.wrench(f"contact:{name}", "chest") for name in ("l_hand", "l_forearm"))
    wrist = query.wrench("joint:l_wrist_pitch", "chest")
    assert len(hand.undecided) == 3  # components of the force at the hand
    np.testing.assert_allclose(hand.undecided, -forearm.undecided, atol=1e-9)
    np.testing.assert_allclose(hand.undecided, wrist.undecided, atol=1e-9)
    for of in ("joint:l_elbow", "joint:r_elbow", "contact:l_sole", "subtree:l_arm", "link:l_hand"):
        assert query.wrench(of).undecided.shape == (0, 6)
