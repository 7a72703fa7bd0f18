"""How wrong the rows of the touches are, and what they say about a wrench on each body."""

from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from scipy.linalg import get_lapack_funcs

from estimation.contact_rows import ContactRows
from estimation.row_layout import RemovedWrenches
from robot_model.messages import SensorFrame

Array = np.ndarray
_potrf, _potri = get_lapack_funcs(("potrf", "potri"))
UNKNOWN = 1e8  # variance of a channel that is missing, in its unit squared


@dataclass(frozen=True)
class RowNoise:
    """Standard deviations of what the sensor frame carries, model errors included."""

    acceleration: float = 0.02  # m/s^2, proper
    angular_acceleration: float = 0.15  # rad/s^2
    joint_acceleration: float = 0.08  # rad/s^2
    ft_force: float = 0.1  # N
    ft_moment: float = 0.01  # N m
    torque: float = 0.3  # N m; leaves room for friction that nobody modelled
    base_force: float = 0.3  # N, errors of the model
    base_moment: float = 0.05  # N m


class RowCovariance:
    """Covariance of the rows: what errors of accelerations and readings do to them.

    A wrong joint acceleration appears in base, joint and force/torque rows together (a
    column of the mass matrix), a touch does not; only the full covariance tells them
    apart. It changes with the posture, so it need not be computed at every sample.

    Attributes:
        matrix: (nv, nv) covariance of ``ContactRows.rows``.
        information: (nv, nv) its inverse on the active rows, zero elsewhere.
    """

    def __init__(self, rows: ContactRows, noise: RowNoise | None = None):
        self.noise = noise or RowNoise()
        self._rows = rows
        layout = rows.layout
        self._model, self._data = layout.model, layout.model.createData()
        self._joint_v, self._cut_v = layout.tree.joint_v, layout.tree.cut_v
        self._rotors = np.zeros((layout.model.nv, layout.model.nv), order="F")
        self._rotors[np.ix_(self._joint_v, self._joint_v)] = rows.robot.rotor_inertia
        self.matrix = np.zeros_like(self._rotors)
        self.information = np.zeros_like(self._rotors)

    def update(
        self,
        frame: SensorFrame,
        removed: RemovedWrenches | None = None,
        model_error: Array | float = 0.0,
    ) -> None:
        """Compute the covariance at the posture of the rows and the validity of a frame.

        Args:
            frame: Sensor frame of which the flags count.
            removed: Wrenches taken from the rows; those of the ``ContactRows`` when None.
            model_error: Standard deviation of what the model predicts, (nv,) or 0.
        """
        removed = self._rows.removed if removed is None else removed
        motion, reading = self._variances(frame)
        reading += np.square(model_error)
        pin.crba(self._model, self._data, self._rows.q, pin.Convention.WORLD)
        spread = self._data.M + self._rotors
        errors = (spread * motion) @ spread.T
        errors[np.diag_indices_from(errors)] += reading
        if removed.subtrees:
            errors = self._without(removed, errors)
        self.matrix = errors
        active = np.flatnonzero(removed.active)
        self.information[:] = 0.0
        self.information[np.ix_(active, active)] = inverse(errors[np.ix_(active, active)])

    def of_wrenches(self) -> Array:
        """Covariance of ``ContactRows.wrenches``, (s, 6, 6)."""
        maps = self._rows.wrench_map()
        return maps @ self.matrix @ maps.transpose(0, 2, 1)

    def _variances(self, frame: SensorFrame) -> tuple[Array, Array]:
        """Variances of the accelerations and of the readings, (nv,) each."""
        noise, nv = self.noise, self._model.nv
        motion, reading = np.zeros(nv), np.zeros(nv)
        motion[:3] = noise.acceleration**2
        motion[3:6] = noise.angular_acceleration**2
        motion[self._joint_v] = noise.joint_acceleration**2
        reading[:3], reading[3:6] = noise.base_force**2, noise.base_moment**2
        trusted = frame.joint_valid & frame.motor_torque_valid
        reading[self._joint_v] = np.where(trusted, noise.torque**2, UNKNOWN)
        sensor = np.repeat([noise.ft_force**2, noise.ft_moment**2], 3)
        reading[self._cut_v] = np.where(frame.ft_valid[:, None], sensor, UNKNOWN)
        return motion, reading

    def _without(self, removed: RemovedWrenches, errors: Array) -> Array:
        """Covariance after some wrenches have been taken from the rows."""
        maps = self._rows.wrench_map()[removed.subtrees]
        remover = np.eye(len(errors))
        for column, wrench_map in enumerate(maps):
            remover -= (removed.bears[:, column, None] * self._rows.jacobian) @ wrench_map
        return remover @ errors @ remover.T


def inverse(matrix: Array) -> Array:
    """Return the inverse of a symmetric positive definite matrix."""
    factor, failed = _potrf(matrix, lower=1)
    if failed:
        raise np.linalg.LinAlgError(f"matrix of order {len(matrix)} is not positive definite")
    result, _ = _potri(factor, lower=1)
    return np.tril(result) + np.tril(result, -1).T
