"""How far the noise of the sensors reaches into the observer's results."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import pinocchio as pin

from estimation.torque_observer import TorqueObserver


@dataclass(frozen=True)
class ObserverNoise:
    """Standard deviations of one sample, white noise and remaining bias together."""

    force: float  # N
    moment: float  # N m
    acceleration: float  # m/s^2, of the inertial sensor
    angular_acceleration: float  # rad/s^2, of the inertial sensor


class Uncertainty(NamedTuple):
    """Covariances of the observer's results at one posture."""

    torque_std: np.ndarray  # (n,) N m
    wrench: np.ndarray  # (s, 6, 6) as Estimate.wrench


def propagate(
    observer: TorqueObserver, noise: ObserverNoise, q: np.ndarray, motion: np.ndarray | None = None
) -> Uncertainty:
    """Propagate sensor noise through the observer at a posture.

    The results are linear in the readings and in the acceleration of the inertial
    sensor; both maps are constant for a posture, so this may run at a low rate. Errors
    of the model, of joint motion and of the gyro's rate are not included.

    Args:
        observer: The observer; its contacts are those in force.
        noise: Standard deviations of the channels.
        q: Joint positions, (n,) rad.
        motion: Covariance (6, 6) of the root's [proper, angular] acceleration; diagonal,
            and the noise's, when None.
    """
    maps = _Maps(observer, q)
    readings = np.repeat([noise.force, noise.moment], 3)
    white = np.repeat([noise.acceleration, noise.angular_acceleration], 3)
    k = len(observer.offset)
    sigma = np.concatenate([white, np.tile(readings, k)])
    wrench, torque = maps.wrench * sigma, maps.torque * sigma
    if motion is not None:
        root = _square_root(motion)
        wrench[..., :6], torque[:, :6] = maps.wrench[..., :6] @ root, maps.torque[:, :6] @ root
    return Uncertainty(np.sqrt((torque**2).sum(axis=1)), wrench @ wrench.transpose(0, 2, 1))


def _square_root(covariance: np.ndarray) -> np.ndarray:
    values, axes = np.linalg.eigh(covariance)
    return axes * np.sqrt(np.maximum(values, 0.0))


class _Maps:
    """Derivatives of the results with respect to [acceleration (6), readings (6 k)]."""

    def __init__(self, observer: TorqueObserver, q: np.ndarray):
        graph = observer.graph
        full = graph.neutral.copy()
        full[graph.tree.joint_q] = q
        jacobian = pin.computeJointJacobians(graph.model, graph.data, full).copy()
        bare = graph.bare_model
        inertial = _acceleration_columns(bare, graph.bare_data, full[: bare.nq])
        entering = self._entering(observer, inertial)
        entering_v = np.vstack([np.arange(6), graph.tree.cut_v])
        force_maps = np.linalg.inv(jacobian[:, entering_v].transpose(1, 2, 0))
        external = np.einsum("st,tij,tjc->sic", graph.incidence, force_maps, entering)
        s, start = len(entering), graph.leaf_v
        leaves = jacobian[:, start : start + 6 * s].T.reshape(s, 6, 6)
        self.wrench = leaves @ external  # (s, 6, 6 + 6 k)
        axes = jacobian[:, graph.tree.joint_v].T
        below = np.einsum("ns,sic->nic", graph.contact_below, external)
        self.torque = -np.einsum("ni,nic->nc", axes, below)
        self.torque[:, :6] += inertial[graph.tree.joint_v]

    @staticmethod
    def _entering(observer: TorqueObserver, inertial: np.ndarray) -> np.ndarray:
        """Predicted minus measured wrench through the root and each sensor, (s, 6, 6 + 6 k)."""
        tree = observer.graph.tree
        k = len(tree.cut_v)
        entering = np.zeros((k + 1, 6, 6 + 6 * k))
        entering[0, :, :6] = inertial[:6]
        for i in range(k):
            entering[i + 1, :, :6] = inertial[tree.cut_v[i]]
            entering[i + 1, :, 6 + 6 * i : 12 + 6 * i] = -tree.cut_sign[i] * np.eye(6)
        return entering


def _acceleration_columns(model: pin.Model, data: pin.Data, q: np.ndarray) -> np.ndarray:
    """Derivative of inverse dynamics with respect to the root's acceleration, (nv, 6)."""
    rest, columns = np.zeros(model.nv), np.zeros((model.nv, 6))
    unit = np.zeros(model.nv)
    for i in range(6):
        unit[i] = 1.0
        columns[:, i] = pin.rnea(model, data, q, rest, unit)
        unit[i] = 0.0
    return columns
