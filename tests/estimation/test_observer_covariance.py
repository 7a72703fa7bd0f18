"""The stated uncertainty of the observer against sampled sensor noise."""

import numpy as np
import pinocchio as pin
import pytest

from estimation.contact_set import Touch
from estimation.observer_covariance import ObserverNoise, propagate
from estimation.torque_observer import TorqueObserver
from robot_model import load_robot
from tests.estimation.observer_states import random_input

NOISE = ObserverNoise(
    force=1.0,
    moment=0.03,
    acceleration=0.05,
    angular_acceleration=0.2,
    angular_velocity=0.01,
    joint_velocity=0.01,
    joint_acceleration=0.2,
    mass=0.03,
    center_of_mass=0.003,
)


@pytest.fixture(scope="module")
def observer():
    return TorqueObserver(load_robot("icub"))


def sampled(observer, state, count):
    rng = np.random.default_rng(11)
    scale = np.repeat([NOISE.force, NOISE.moment], 3)
    sizes = {
        "ft": scale,
        "acc": NOISE.acceleration,
        "dgyro": NOISE.angular_acceleration,
        "gyro": NOISE.angular_velocity,
        "dq": NOISE.joint_velocity,
        "ddq": NOISE.joint_acceleration,
    }
    bodies, inertias = (
        [body for body, _ in observer.graph.bodies],
        observer.graph.bare_model.inertias,
    )
    right = {body: inertias[body].copy() for body in bodies}
    for _ in range(count):
        for body, inertia in right.items():
            factor = 1.0 + NOISE.mass * rng.normal()
            center = inertia.lever + NOISE.center_of_mass * rng.normal(size=3)
            inertias[body] = pin.Inertia(factor * inertia.mass, center, factor * inertia.inertia)
        errors = {
            name: size * rng.normal(size=getattr(state, name).shape) for name, size in sizes.items()
        }
        yield observer.step(
            *state._replace(**{name: getattr(state, name) + e for name, e in errors.items()})
        )
    for body, inertia in right.items():
        inertias[body] = inertia


@pytest.mark.parametrize("hand", ["none", "force"])
def test_stated_uncertainty_equals_the_scatter_of_noisy_samples(observer, hand):
    touches = [Touch("r_hand", np.zeros(3), hand), ("l_forearm", np.array([0.0, 0.02, 0.05]))]
    if hand == "force":  # the left arm's wrench is shared
        touches.append(Touch("l_hand", np.zeros(3), "force"))
    observer.set_contacts(touches)
    state = random_input(observer.robot, np.random.default_rng(0))
    stated = propagate(observer, NOISE, *state[:3], *state[4:])
    samples = list(sampled(observer, state, 3000))
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
