"""The torque observer beside iDynTree: same inputs, same answers."""

import numpy as np
import pytest

from benchmarks.idyntree_observer import IdyntreeObserver
from estimation.torque_observer import TorqueObserver
from tests.estimation.observer_states import random_input
from tests.estimation.random_robots import limbed_robot

STATES = 500


@pytest.fixture(scope="module")
def pair(peer_robot):
    observer = TorqueObserver(peer_robot)
    return observer, IdyntreeObserver(observer.robot, [c.frame for c in observer.contacts])


def relative(ours, theirs):
    return np.abs(ours - theirs).max() / max(1.0, np.abs(theirs).max())


def test_torques_and_wrenches_equal_idyntrees_on_random_states(pair):
    observer, peer = pair
    rng = np.random.default_rng(7)
    for _ in range(STATES):
        state = random_input(observer.robot, rng)
        ours = observer.step(*state)
        torque, wrench = peer.step(*state._replace(ft=-state.ft))
        assert relative(ours.torque, torque) < 1e-9
        assert relative(ours.wrench, peer.in_frame_axes(wrench)) < 1e-9


def test_every_sensors_prediction_is_idyntrees_reading_without_contacts(pair):
    observer, peer = pair
    rng = np.random.default_rng(8)
    root = observer.robot.subtrees[0]
    for _ in range(20):
        state = random_input(observer.robot, rng)
        predicted = observer.step(*state).predicted
        # Fed with the prediction, the peer finds no external wrench but the root's.
        _, wrench = peer.step(*state._replace(ft=-predicted))
        assert root.ft_in == -1
        assert np.abs(wrench[1:]).max() < 1e-9


def test_each_sensor_moves_its_two_subtrees_as_in_idyntree(pair):
    observer, peer = pair
    for sensor in range(len(observer.robot.ft_sensors)):
        moves_its_two_subtrees(observer, peer, sensor)


def moves_its_two_subtrees(observer, peer, sensor):
    state = random_input(observer.robot, np.random.default_rng(sensor))
    ft = state.ft.copy()
    ft[sensor] += [1.0, -2.0, 3.0, 0.4, 0.5, -0.6]
    ours = observer.step(*state._replace(ft=ft)).wrench - observer.step(*state).wrench
    _, with_change = peer.step(*state._replace(ft=-ft))
    _, without = peer.step(*state._replace(ft=-state.ft))
    theirs = peer.in_frame_axes(with_change) - peer.in_frame_axes(without)
    np.testing.assert_allclose(ours, theirs, atol=1e-9)
    moved = {i for i in range(len(ours)) if np.abs(ours[i]).max() > 1e-6}
    child = sensor + 1
    parent = next(
        i for i, subtree in enumerate(observer.robot.subtrees) if sensor in subtree.ft_out
    )
    assert moved == {child, parent}


@pytest.mark.parametrize(("joints", "sensors"), [(7, 1), (36, 12), (100, 6)])
def test_robots_of_any_size_equal_idyntrees(tmp_path, joints, sensors):
    robot = limbed_robot(tmp_path, joints, sensors)
    assert (robot.n, len(robot.ft_sensors)) == (joints, sensors)
    observer = TorqueObserver(robot, "none")
    peer = IdyntreeObserver(robot, [contact.frame for contact in observer.contacts])
    rng = np.random.default_rng(joints)
    for _ in range(20):
        state = random_input(robot, rng)
        ours = observer.step(*state)
        torque, wrench = peer.step(*state._replace(ft=-state.ft))
        assert relative(ours.torque, torque) < 1e-9
        assert relative(ours.wrench, peer.in_frame_axes(wrench)) < 1e-9
