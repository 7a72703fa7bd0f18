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

    @property
    def reading(self) -> Array:
        """Standard deviations of a force/torque reading, (6,)."""
        return np.repeat([self.force, self.moment], 3)


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
    maps = ErrorMaps(observer, state, noise, source)
    wrench, net, prediction = (
        map @ map.transpose(0, 2, 1) for map in (maps.wrench, maps.net, maps.prediction)
    )
    return Uncertainty(np.sqrt((maps.torque**2).sum(axis=1)), wrench, net, prediction)


def _square_root(covariance: Array) -> Array:
    values, axes = np.linalg.eigh(covariance)
    return axes * np.sqrt(np.maximum(values, 0.0))


class ErrorMaps:
    """Results of one standard deviation of each error: p of motion and bodies, 6 k readings.

    Args:
        observer, noise, source: As in ``propagate``.
        state: Configuration, velocity and acceleration of the model without leaves.
    """

    forces: Array  # (nv, p) of the inverse dynamics; the root's rows are of the whole robot
    prediction: Array  # (k, 6, p + 6 k) of predicted - measured readings
    wrench: Array  # (c, 6, p + 6 k) of the contacts, as Estimate.wrench
    net: Array  # (s, 6, p + 6 k) of the sub-trees, as Estimate.subtree_wrench
    below: Array  # (n, 6, p + 6 k) of what the world exerts below each joint, about the root
    torque: Array  # (n, p + 6 k)

    def __init__(
        self, observer: TorqueObserver, state: State, noise: ObserverNoise, source: Array | None
    ):
        self.observer, self.noise = observer, noise
        self._root = np.diag(np.repeat([noise.acceleration, noise.angular_acceleration], 3))
        if source is not None:
            self._root = _square_root(source)
        self.forces = self._generalised_forces(state)
        self._solve(state[0])

    def by_motion(self, by_velocity: Array, by_acceleration: Array) -> list[Array]:
        """Return what errors of the motion do, given derivatives (r, nv) by the model's motion."""
        noise, joint_v = self.noise, self.observer.graph.tree.joint_v
        return [
            by_acceleration[:, :6] @ self._root,
            by_velocity[:, 3:6] * noise.angular_velocity,
            by_velocity[:, joint_v] * noise.joint_velocity,
            by_acceleration[:, joint_v] * noise.joint_acceleration,
        ]

    def _generalised_forces(self, state: State) -> Array:
        observer, noise = self.observer, self.noise
        model, data = observer.graph.bare_model, observer.graph.bare_data
        _, by_velocity, by_acceleration = pin.computeRNEADerivatives(model, data, *state)
        inertia = np.triu(by_acceleration) + np.triu(by_acceleration, 1).T
        columns = self.by_motion(by_velocity, inertia)
        if noise.mass or noise.center_of_mass:
            regressor = pin.computeJointTorqueRegressor(model, data, *state)
            columns += _by_bodies(observer, regressor, noise)
        return np.hstack(columns)

    def _solve(self, q: Array) -> None:
        observer, graph, forces = self.observer, self.observer.graph, self.forces
        full = graph.neutral.copy()
        full[: len(q)] = q
        jacobian = pin.computeJointJacobians(graph.model, graph.data, full).copy()
        entering_v = np.vstack([np.arange(6), graph.tree.cut_v])
        force_maps = np.linalg.inv(jacobian[:, entering_v].transpose(1, 2, 0))
        entering = _entering(observer, forces, self.noise)
        self.prediction = entering[1:]
        external = _combined(graph.incidence, force_maps @ entering)
        s, start = len(entering), graph.leaf_v
        leaves = jacobian[:, start : start + 6 * s].T.reshape(s, 6, 6)
        below = _combined(graph.contact_below, external)
        self.wrench = np.zeros((len(observer.contacts), *external.shape[1:]))
        self.net = leaves @ external
        self.wrench[observer.lone_rows] = self.net[observer.lone_subtrees]
        for row, joint, joint_m_frame in observer.moved:
            root_m_frame = graph.data.oMi[joint] * joint_m_frame
            self.net[row] = root_m_frame.toActionMatrix().T @ external[row]
        for subtree in observer.shared:
            shares, net = subtree.at(graph.data), external[subtree.row]
            self.wrench[subtree.rows] = shares.solution.gain @ net
            below += shares.moved(self.wrench[subtree.rows], net)
        self.below = below
        axes = jacobian[:, graph.tree.joint_v].T
        self.torque = -(axes[:, None, :] @ below)[:, 0]
        self.torque[:, : forces.shape[1]] += forces[graph.tree.joint_v]


def _combined(weights: Array, blocks: Array) -> Array:
    """Return the sums (r, 6, c) of blocks (s, 6, c) with weights (r, s)."""
    return (weights @ blocks.reshape(len(blocks), -1)).reshape(len(weights), *blocks.shape[1:])


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
    readings = np.diag(noise.reading)
    entering = np.zeros((k + 1, 6, p + 6 * k))
    entering[0, :, :p] = forces[:6]
    for i in range(k):
        entering[i + 1, :, :p] = forces[tree.cut_v[i]]
        entering[i + 1, :, p + 6 * i : p + 6 * i + 6] = -tree.cut_sign[i] * readings
    return entering
