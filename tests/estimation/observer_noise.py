"""Inputs of the torque observer with the errors that its covariance is told of."""

from collections.abc import Iterator

import numpy as np
import pinocchio as pin

from estimation.observer_covariance import ObserverNoise
from estimation.torque_observer import TorqueObserver
from tests.estimation.observer_states import ObserverInput

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


def noisy(observer: TorqueObserver, state: ObserverInput, count: int) -> Iterator[ObserverInput]:
    """Yield a state with errors drawn anew; the observer's bodies have errors meanwhile."""
    rng = np.random.default_rng(11)
    sizes = {
        "ft": NOISE.reading,
        "acc": NOISE.acceleration,
        "dgyro": NOISE.angular_acceleration,
        "gyro": NOISE.angular_velocity,
        "dq": NOISE.joint_velocity,
        "ddq": NOISE.joint_acceleration,
    }
    inertias = observer.graph.bare_model.inertias
    right = {body: inertias[body].copy() for body, _ in observer.graph.bodies}
    for _ in range(count):
        for body, inertia in right.items():
            inertias[body] = off(inertia, rng)
        errors = {
            name: size * rng.normal(size=getattr(state, name).shape) for name, size in sizes.items()
        }
        yield state._replace(**{name: getattr(state, name) + e for name, e in errors.items()})
    for body, inertia in right.items():
        inertias[body] = inertia


def off(inertia: pin.Inertia, rng: np.random.Generator) -> pin.Inertia:
    """Return an inertia with another mass, in proportion, and another centre of mass."""
    factor = 1.0 + NOISE.mass * rng.normal()
    center = inertia.lever + NOISE.center_of_mass * rng.normal(size=3)
    return pin.Inertia(factor * inertia.mass, center, factor * inertia.inertia)
