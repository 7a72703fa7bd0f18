"""The stated uncertainty of the observer against sampled sensor noise."""

import numpy as np
import pytest

from estimation.contact_set import Touch
from estimation.observer_covariance import propagate
from estimation.torque_observer import TorqueObserver
from robot_model import load_robot
from tests.estimation.observer_noise import NOISE, noisy
from tests.estimation.observer_states import random_input


@pytest.fixture(scope="module")
def observer():
    return TorqueObserver(load_robot("icub"))


@pytest.mark.parametrize("hand", ["none", "force"])
def test_stated_uncertainty_equals_the_scatter_of_noisy_samples(observer, hand):
    touches = [Touch("r_hand", np.zeros(3), hand), ("l_forearm", np.array([0.0, 0.02, 0.05]))]
    if hand == "force":  # the left arm's wrench is shared
        touches.append(Touch("l_hand", np.zeros(3), "force"))
    observer.set_contacts(touches)
    state = random_input(observer.robot, np.random.default_rng(0))
    stated = propagate(observer, NOISE, *state[:3], *state[4:])
    samples = [observer.step(*input) for input in noisy(observer, state, 3000)]
    torque = np.array([sample.torque for sample in samples]).std(axis=0)
    wrench = np.array([sample.wrench for sample in samples]).std(axis=0)
    net = np.array([sample.subtree_wrench for sample in samples]).std(axis=0)
    missed = np.array([sample.predicted - sample.measured for sample in samples]).std(axis=0)
    std, net_std, missed_std = (np.sqrt(np.diagonal(c, axis1=1, axis2=2)) for c in stated[1:])
    np.testing.assert_allclose(torque, stated.torque_std, rtol=0.06)
    np.testing.assert_allclose(wrench, std, rtol=0.06, atol=1e-9)
    np.testing.assert_allclose(net, net_std, rtol=0.06)
    np.testing.assert_allclose(missed, missed_std, rtol=0.06)


def test_covariances_are_symmetric_and_positive_definite(observer):
    observer.set_contacts()
    state = random_input(observer.robot, np.random.default_rng(0))
    stated = propagate(observer, NOISE, *state[:3], *state[4:])
    for covariance in stated[1:]:
        np.testing.assert_allclose(covariance, covariance.transpose(0, 2, 1))
        assert (np.linalg.eigvalsh(covariance) > 0.0).all()
    assert (stated.torque_std > 0.0).all()
