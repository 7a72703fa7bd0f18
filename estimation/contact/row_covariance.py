"""How wrong the rows of the touches are, and what they say about a wrench on each body."""

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np
import pinocchio as pin
from scipy.linalg import get_lapack_funcs

from estimation.contact.contact_rows import ContactRows
from estimation.contact.row_layout import RemovedWrenches
from robot_model.messages import SensorFrame

Array = np.ndarray
_potrf, _trtri, _trtrs = get_lapack_funcs(("potrf", "trtri", "trtrs"))
RISE = 1.5  # of an acceleration's deviation, from which a covariance is too small
TRAVEL = 0.03  # rad times rad/s^2; so far the joints go, and so wrong are their accelerations
UNKNOWN = 1e8  # variance of a channel that is missing, in its unit squared


@dataclass(frozen=True)
class RowNoise:
    """Standard deviations of what the sensor frame carries, model errors included."""

    acceleration: float = 0.02  # m/s^2, proper
    angular_acceleration: float = 0.15  # rad/s^2
    joint_acceleration: float = 0.08  # rad/s^2, least; encoders that count make more
    ft_force: float = 0.1  # N
    ft_moment: float = 0.01  # N m
    torque: float = 0.03  # N m, of the motors
    friction: float = 0.3  # N m; room for what nobody modelled, until a calibration finds it
    base_force: float = 0.3  # N, errors of the model
    base_moment: float = 0.05  # N m


class RowCovariance:
    """Covariance of the rows: what errors of accelerations and readings do to them.

    A wrong joint acceleration appears in base, joint and force/torque rows together (a
    column of the mass matrix), a touch does not; only the full covariance tells them
    apart. It changes with the posture, so it need not be computed at every sample.

    Attributes:
        matrix: (nv, nv) covariance of ``ContactRows.rows``.
        active: Indices of the rows that still say something.
        variances: (nv,) of the readings alone, before the supports are removed.
        jacobian: (nv, 6) that of the rows at the posture of the covariance.
    """

    def __init__(self, rows: ContactRows, noise: RowNoise | None = None):
        self.noise = noise or RowNoise()
        self._rows = rows
        layout = rows.layout
        nv = layout.model.nv
        self._model, self._data = layout.model, layout.model.createData()
        self._joint_v, self._cut_v = layout.tree.joint_v, layout.tree.cut_v
        self._rotors = np.zeros((nv, nv), order="F")
        self._rotors[np.ix_(self._joint_v, self._joint_v)] = rows.robot.rotor_inertia
        self._motion, self._reading = self._deviations()
        self._friction = np.zeros(nv)  # variance
        self._friction[self._joint_v] = self.noise.friction**2
        self._joint_deviation = self._motion[self._joint_v]
        self._posture = rows.q[layout.tree.joint_q]
        self._diagonal = np.diag_indices(nv)
        self.matrix, self.variances = np.zeros((nv, nv)), np.zeros(nv)
        self.active, self.jacobian = np.arange(nv), np.zeros((nv, 6))
        self._inlets = layout.inlets.reshape(-1)

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
        for _ in self.renewal(frame, removed, model_error):
            pass

    def renewal(
        self,
        frame: SensorFrame,
        removed: RemovedWrenches | None = None,
        model_error: Array | float = 0.0,
    ) -> Iterator[None]:
        """``update`` in two pieces, at the posture of the rows at the first one."""
        removed = self._rows.removed if removed is None else removed
        variances = self._variances(frame) + np.square(model_error)
        jacobian, blocks = self._rows.jacobian.copy(), self._rows.wrench_blocks()
        errors = self._errors(variances, self._deviation_of_motion(frame))
        yield
        self.matrix = self._without(removed, errors, jacobian, blocks)
        self.variances, self.jacobian, self._blocks = variances, jacobian, blocks
        self.active = np.flatnonzero(removed.active)

    def expect(self, frame: SensorFrame) -> None:
        """Take what ``outdated`` compares with from a frame."""
        least = self.noise.joint_acceleration
        told = frame.ddq_deviation
        self._joint_deviation = np.full(len(frame.ddq), least) if told is None else told.clip(least)
        self._posture = frame.q

    def outdated(self, frame: SensorFrame) -> bool:
        """Whether an acceleration is much more uncertain than at the last ``update``, or the
        posture so far away that its column of the mass matrix is another."""
        told, used = frame.ddq_deviation, self._joint_deviation
        if told is None:
            return False
        travel = np.abs(frame.q - self._posture).max()
        return travel * used.max() > TRAVEL or bool((told > RISE * used).any())

    def whiten(self, vectors: Array) -> Array:
        """Return vectors of rows, (m, nv), in standard deviations, (m, active rows).

        Products of whitened vectors are those by the inverse covariance of the active rows.
        """
        factor, active = self._factor(), self.active
        # both transposed: LAPACK then takes and returns them without another copy
        return _trtrs(factor, vectors.take(active, axis=1).T, lower=1, overwrite_b=1)[0].T

    def information(self) -> Array:
        """Return the inverse covariance of the active rows, (a, a)."""
        back = _trtri(self._factor(), lower=1, overwrite_c=1)[0]
        return back.T @ back

    def of_wrenches(self) -> Array:
        """Covariance of ``ContactRows.wrenches``, (s, 6, 6)."""
        blocks, inlets = self._blocks, self._inlets
        seen = blocks.reshape(-1, len(inlets)) @ self.matrix[inlets[:, None], inlets]
        return seen.reshape(blocks.shape) @ blocks.transpose(0, 2, 1)

    def _factor(self) -> Array:
        """Lower Cholesky factor of the covariance of the active rows, (a, a)."""
        active = self.active
        inside = self.matrix.take(active, axis=0).take(active, axis=1)
        factor, failed = _potrf(inside, lower=1)
        if failed:
            raise np.linalg.LinAlgError("the covariance of the rows is not positive definite")
        return factor

    def _errors(self, variances: Array, motion: Array) -> Array:
        """Covariance of the rows before the supports are removed, (nv, nv)."""
        pin.crba(self._model, self._data, self._rows.q, pin.Convention.WORLD)
        spread = (self._data.M + self._rotors) * motion
        errors = spread @ spread.T + self._rows.bias.covariance
        errors[self._diagonal] += variances
        return errors

    def _deviations(self) -> tuple[Array, Array]:
        """Standard deviations of the accelerations and of the readings, (nv,) each."""
        noise, nv = self.noise, self._model.nv
        motion, reading = np.zeros(nv), np.zeros(nv)
        motion[:3], motion[3:6] = noise.acceleration, noise.angular_acceleration
        motion[self._joint_v] = noise.joint_acceleration
        reading[:3], reading[3:6] = noise.base_force, noise.base_moment
        reading[self._joint_v] = noise.torque
        reading[self._cut_v] = np.repeat([noise.ft_force, noise.ft_moment], 3)
        return motion, reading

    def _deviation_of_motion(self, frame: SensorFrame) -> Array:
        """Standard deviations of the accelerations of a frame, (nv,)."""
        self.expect(frame)
        motion = self._motion.copy()
        motion[self._joint_v] = self._joint_deviation
        return motion

    def _variances(self, frame: SensorFrame) -> Array:
        """Variances of the readings, (nv,)."""
        floor = self._friction if self._rows.floor is None else self._rows.floor
        variances = np.square(self._reading) + floor
        trusted = frame.joint_valid & frame.motor_torque_valid
        variances[self._joint_v[~trusted]] = UNKNOWN
        variances[self._cut_v[~frame.ft_valid]] = UNKNOWN
        return variances

    def _without(
        self, removed: RemovedWrenches, errors: Array, jacobian: Array, blocks: Array
    ) -> Array:
        """Covariance E after some wrenches have been taken from the rows.

        With W from rows to wrenches and U back, (1 - U W) E (1 - U W)^T; few wrenches are
        removed, so the small products come first.
        """
        if not removed.subtrees:
            return errors
        inlets = self._inlets
        wrench_map = blocks[removed.subtrees].reshape(-1, len(inlets))
        back = (removed.bears[:, :, None] * jacobian[:, None]).reshape(len(errors), -1)
        seen = wrench_map @ errors[inlets]
        taken = back @ (seen - 0.5 * (seen[:, inlets] @ wrench_map.T) @ back.T)
        errors -= taken
        errors -= taken.T
        return errors
