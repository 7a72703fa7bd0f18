"""How far errors of sensors, of differentiation and of the model reach into the results."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from estimation.torque_observer import TorqueObserver

Array = np.ndarray
State = tuple[Array, Array, Array]


@dataclass(frozen=True)
class ObserverNoise:
    """Standard deviations of one sample, white noise and remaining bias together."""

    force: float  # N
    moment: float  # N m
    acceleration: float  # m/s^2, of the inertial sensor
    angular_acceleration: float  # rad/s^2, of the inertial sensor
    angular_velocity: float = 0.0  # rad/s, of the inertial sensor
    joint_velocity: float = 0.0  # rad/s
    joint_acceleration: float = 0.0  # rad/s^2
    mass: float = 0.0  # of a body's mass, as a share of it; its inertia goes with it
    center_of_mass: float = 0.0  # m, each axis of each body


class Uncertainty(NamedTuple):
    """Covariances of the observer's results at one instant."""

    torque_std: Array  # (n,) N m
    wrench: Array  # (c, 6, 6) as Estimate.wrench
    subtree_wrench: Array  # (s, 6, 6) as Estimate.subtree_wrench
    prediction: Array  # (k, 6, 6) of Estimate.predicted - Estimate.measured


def propagate(
    observer: TorqueObserver,
    noise: ObserverNoise,
    q: Array,
    dq: Array,
    ddq: Array,
    gyro: Array,
    acc: Array,
    dgyro: Array,
    source: Array | None = None,
) -> Uncertainty:
    """Propagate all errors through the observer, linearised at an instant.

    The maps change with posture and motion only, so this may run at a low rate. Errors are
    independent of each other; those of joint positions are not included, nor what the
    sensors leave undecided among several contacts.

    Args:
        observer: The observer; its contacts are those in force.
        noise: Standard deviations of the channels and of the bodies.
        q, dq, ddq, gyro, acc, dgyro: As ``TorqueObserver.step``.
        source: Covariance (6, 6) of the root's [proper, angular] acceleration; diagonal,
            and the noise's, when None.
    """
    state = observer.motion(q, dq, ddq, gyro, acc, dgyro)
    maps = _Maps(observer, state, noise, source)
    wrench, net, prediction = (
        map @ map.transpose(0, 2, 1) for map in (maps.wrench, maps.net, maps.prediction)
    )
    return Uncertainty(np.sqrt((maps.torque**2).sum(axis=1)), wrench, net, prediction)


def _square_root(covariance: Array) -> Array:
    values, axes = np.linalg.eigh(covariance)
    return axes * np.sqrt(np.maximum(values, 0.0))


class _Maps:
    """Results of one standard deviation of each error: p of motion and bodies, 6 k readings.

    Args:
        state: Configuration, velocity and acceleration of the model without leaves.
        source: As in ``propagate``.
    """

    def __init__(
        self, observer: TorqueObserver, state: State, noise: ObserverNoise, source: Array | None
    ):
        graph, q = observer.graph, state[0]
        forces = _generalised_forces(observer, state, noise, source)
        full = graph.neutral.copy()
        full[: len(q)] = q
        jacobian = pin.computeJointJacobians(graph.model, graph.data, full).copy()
        entering_v = np.vstack([np.arange(6), graph.tree.cut_v])
        force_maps = np.linalg.inv(jacobian[:, entering_v].transpose(1, 2, 0))
        entering = _entering(observer, forces, noise)
        self.prediction = entering[1:]  # (k, 6, p + 6 k)
        external = _combined(graph.incidence, force_maps @ entering)
        s, start = len(entering), graph.leaf_v
        leaves = jacobian[:, start : start + 6 * s].T.reshape(s, 6, 6)
        below = _combined(graph.contact_below, external)
        self.wrench = np.zeros((len(observer.contacts), *external.shape[1:]))  # (c, 6, p + 6 k)
        self.net = leaves @ external  # (s, 6, p + 6 k)
        self.wrench[observer.lone_rows] = self.net[observer.lone_subtrees]
        for row, joint, joint_m_frame in observer.moved:
            root_m_frame = graph.data.oMi[joint] * joint_m_frame
            self.net[row] = root_m_frame.toActionMatrix().T @ external[row]
        for subtree in observer.shared:
            shares, net = subtree.at(graph.data), external[subtree.row]
            self.wrench[subtree.rows] = shares.solution.gain @ net
            below += shares.moved(self.wrench[subtree.rows], net)
        axes = jacobian[:, graph.tree.joint_v].T
        self.torque = -(axes[:, None, :] @ below)[:, 0]
        self.torque[:, : forces.shape[1]] += forces[graph.tree.joint_v]


def _combined(weights: Array, blocks: Array) -> Array:
    """Return the sums (r, 6, c) of blocks (s, 6, c) with weights (r, s)."""
    return (weights @ blocks.reshape(len(blocks), -1)).reshape(len(weights), *blocks.shape[1:])


def _generalised_forces(
    observer: TorqueObserver, state: State, noise: ObserverNoise, source: Array | None
) -> Array:
    """Change of the inverse dynamics by one standard deviation of each error, (nv, p)."""
    graph, joint_v = observer.graph, observer.graph.tree.joint_v
    model, data = graph.bare_model, graph.bare_data
    _, by_velocity, by_acceleration = pin.computeRNEADerivatives(model, data, *state)
    inertia = np.triu(by_acceleration) + np.triu(by_acceleration, 1).T
    root = np.diag(np.repeat([noise.acceleration, noise.angular_acceleration], 3))
    columns = [
        inertia[:, :6] @ (root if source is None else _square_root(source)),
        by_velocity[:, 3:6] * noise.angular_velocity,
        by_velocity[:, joint_v] * noise.joint_velocity,
        inertia[:, joint_v] * noise.joint_acceleration,
    ]
    if noise.mass or noise.center_of_mass:
        columns += _by_bodies(observer, pin.computeJointTorqueRegressor(model, data, *state), noise)
    return np.hstack(columns)


def _by_bodies(observer: TorqueObserver, regressor: Array, noise: ObserverNoise) -> list[Array]:
    """The same of each body's mass, (nv, b), and of its centre of mass, (nv, 3 b)."""
    bodies = np.array([body for body, _ in observer.graph.bodies])
    parameters, by_center = observer.graph.body_parameters
    by_body = regressor.reshape(len(regressor), -1, 10)[:, bodies - 1].transpose(1, 0, 2)
    mass = (by_body @ parameters[:, :, None])[:, :, 0].T * noise.mass
    center = (by_body @ by_center.transpose(0, 2, 1)).transpose(1, 0, 2) * noise.center_of_mass
    return [mass, center.reshape(len(regressor), -1)]


def _entering(observer: TorqueObserver, forces: Array, noise: ObserverNoise) -> Array:
    """Predicted minus measured wrench through the root and each sensor, (s, 6, p + 6 k)."""
    tree, p = observer.graph.tree, forces.shape[1]
    k = len(tree.cut_v)
    readings = np.diag(np.repeat([noise.force, noise.moment], 3))
    entering = np.zeros((k + 1, 6, p + 6 * k))
    entering[0, :, :p] = forces[:6]
    for i in range(k):
        entering[i + 1, :, :p] = forces[tree.cut_v[i]]
        entering[i + 1, :, p + 6 * i : p + 6 * i + 6] = -tree.cut_sign[i] * readings
    return entering
