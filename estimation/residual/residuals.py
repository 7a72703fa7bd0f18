"""Internal, external and classical residuals of a robot, sample by sample."""

from typing import NamedTuple

import numpy as np
import pinocchio as pin

from estimation.joint_friction import JointFriction
from estimation.residual.floating_terms import floating_terms
from estimation.residual.free_fall import FreeFallVelocity
from estimation.residual.momentum_filter import MomentumFilter
from estimation.residual.residual_model import is_measured, residual_model
from robot_model import Robot

Array = np.ndarray
OWN_AXES = pin.ReferenceFrame.LOCAL


class ResidualSample(NamedTuple):
    """Residuals: generalised forces of touches, by the joints and by the base."""

    internal: Array  # (n,) N m, R eq. (11)
    external: Array  # (6,) [N, N m] in base axes about the base's origin, R eq. (16)
    classical: Array  # (n,) N m, R eq. (7)


class FloatingResiduals:
    """Residuals of a floating-base robot whose supports are measured.

    Torques are those of the motors: the momentum holds the rotors, and viscous and
    Coulomb friction are taken from the torques. Readings of the supports' sensors are
    known contacts (R eq. 10). The base's velocity is that of a freely falling frame
    (``FreeFallVelocity``), so neither attitude nor an estimate of the base is needed.

    Args:
        robot: The robot.
        support: Kind of support, "floor" or "none".
        internal_gain, external_gain: 1/s, scalar or (n,) and (6,).
        rebase_time: How long the frame falls before it is taken anew [s].
    """

    def __init__(
        self,
        robot: Robot,
        support: str = "floor",
        internal_gain: float | Array = 25.0,
        external_gain: float | Array = 25.0,
        rebase_time: float = 0.2,
    ):
        if not is_measured(robot, support):
            raise ValueError(f"support '{support}' of {robot.name} is not measured")
        self.robot = robot
        self._layout = layout = residual_model(robot, support)
        self._model = layout.model
        self._model.gravity.linear = np.zeros(3)
        self._bind(layout.joint_v)
        self._filter = MomentumFilter(2 * self._model.nv, 1.0)
        self.set_gains(internal_gain, external_gain)
        self._fall = FreeFallVelocity()
        self._rebase_time = rebase_time
        self._age = -1.0  # [s] of the falling frame; negative before the first sample

    def set_gains(self, internal: float | Array, external: float | Array) -> None:
        """Set gains [1/s]; ``internal`` (n,) in the description's order, also for classical."""
        gain = np.ones_like(self._filter.gain)
        gain[:6] = external
        gain[self._internal] = internal
        gain[self._classical] = internal
        self._filter.gain = gain

    def reset(self) -> None:
        """Start again from zero with the next sample."""
        self._filter.reset()
        self._age = -1.0

    def step(
        self,
        q: Array,
        dq: Array,
        motor_torque: Array,
        ft: Array,
        gyro: Array,
        acc: Array,
        period: float,
    ) -> None:
        """Take one sample, ``period`` seconds after the last one; then see ``sample``.

        Args:
            q, dq, motor_torque: (n,) rad, rad/s, N m.
            ft: Readings, (k, 6) parent on child, sensor frames.
            gyro, acc: Angular velocity and proper acceleration of the first IMU, (3,).
        """
        self.add(motor_torque, ft, gyro, acc, period)
        self.evaluate(q, dq)

    def add(self, motor_torque: Array, ft: Array, gyro: Array, acc: Array, period: float) -> None:
        """Integrate what acts, at every sample; a tenth of the work of ``evaluate``."""
        self._gyro = gyro
        first = self._age < 0.0
        if first:
            self._fall.reset(gyro, acc)
            self._age = 0.0
        else:
            self._fall.step(gyro, acc, period)
            self._age += period
        self._impulse.add(motor_torque, ft, 0.0 if first else period)

    def evaluate(self, q: Array, dq: Array) -> None:
        """Bring the residuals up to the sample added last, whose motion this is."""
        torque, ft, period = self._impulse.take_mean()
        self._place(q, dq)
        self._act(torque, ft)
        momentum, rate, force = self._terms()
        self._filter.step(momentum, rate, period, force)
        if self._age >= self._rebase_time:
            self._fall.rebase()
            self._age = 0.0
            momentum, rate, _ = self._terms()
            self._filter.rebase(momentum, rate)

    @property
    def sample(self) -> ResidualSample:
        """The residuals after the last step; zero after a reset."""
        values, n = self.values, self.robot.n
        return ResidualSample(values[6 : 6 + n], values[:6], values[6 + n :])

    @property
    def values(self) -> Array:
        """The same in one piece: external, internal and classical, (6 + 2 n,)."""
        return self._filter.residual.take(self._told)

    def _bind(self, joint_v: Array) -> None:
        """Take views of Pinocchio's results, which stay where they are in memory."""
        robot, nv = self.robot, self._model.nv
        self._data = data = self._model.createData()
        self._mass, self._coriolis = data.M, data.C
        self._q = pin.neutral(self._model)
        self._v, self._acting = np.zeros(nv), np.zeros(nv)
        self._classical, self._internal = joint_v, joint_v + nv
        self._told = np.concatenate((np.arange(6), self._internal, self._classical))
        self._imu_twist = np.zeros(6)
        # in Pinocchio's order: adding arrays of unlike orders takes four times as long
        self._rotors = np.zeros((nv, nv), order="F")
        self._rotors[np.ix_(joint_v, joint_v)] = robot.rotor_inertia
        coefficients = np.zeros((2, nv))
        coefficients[:, joint_v] = robot.viscous, robot.coulomb
        self._friction = JointFriction(*coefficients)
        self._impulse = _Impulse()

    def _place(self, q: Array, dq: Array) -> None:
        layout = self._layout
        self._q[layout.joint_q] = q
        self._v[layout.joint_v] = dq
        pin.crba(self._model, self._data, self._q, pin.Convention.WORLD)  # fills J too
        self._mass += self._rotors

    def _act(self, torque: Array, ft: Array) -> None:
        """Compute the generalised force of motors and supports."""
        layout, acting = self._layout, self._acting
        acting[:6], acting[layout.joint_v] = 0.0, torque
        for sensor, frame in zip(layout.sensors, layout.sensor_frames, strict=True):
            # the foot on its parent: minus the reading
            acting -= ft[sensor].dot(self._jacobian(frame))

    def _jacobian(self, frame: int) -> Array:
        """Jacobian of a frame in its own axes, (6, nv)."""
        return pin.getFrameJacobian(self._model, self._data, frame, OWN_AXES)

    def _terms(self) -> Array:
        """Return momenta, rates and mean forces, columns of v, then internal, (3, 2 nv)."""
        v, twist, imu = self._v, self._imu_twist, self._layout.imu_frame
        twist[:3], twist[3:] = self._fall.velocity, self._gyro
        place = pin.updateFramePlacement(self._model, self._data, imu)
        v[:6] = 0.0
        v[:6] = place.toActionMatrix().dot(twist - self._jacobian(imu).dot(v))
        pin.computeCoriolisMatrix(self._model, self._data, self._q, v)
        friction = self._friction.torque(v)
        return floating_terms(self._mass, self._coriolis, v, friction, self._acting).reshape(3, -1)


class _Impulse:
    """Means of motor torques and readings between two evaluations, by the trapezoidal rule."""

    def __init__(self) -> None:
        # samples since the last evaluation, its own included, and the times between them
        self._torques: list[Array] = []
        self._readings: list[Array] = []
        self._periods: list[float] = []

    def add(self, torque: Array, ft: Array, period: float) -> None:
        """Add a sample ``period`` seconds after the last one; 0 starts again."""
        if period <= 0.0:
            self._torques, self._readings, self._periods = [], [], []
        else:
            self._periods.append(period)
        self._torques.append(torque)
        self._readings.append(ft)

    def take_mean(self) -> tuple[Array, Array, float]:
        """Return mean torque and readings since the last call, and the time passed [s]."""
        torques, readings, periods = self._torques, self._readings, self._periods
        self._torques, self._readings, self._periods = torques[-1:], readings[-1:], []
        time = sum(periods)
        if len(periods) == 1:
            return 0.5 * (torques[0] + torques[1]), 0.5 * (readings[0] + readings[1]), time
        half = 0.5 / time if time else 0.0
        before, after = [0.0, *periods], [*periods, 0.0]
        weights = [half * (x + y) for x, y in zip(before, after, strict=True)]
        flat = np.array(readings).reshape(len(readings), -1)
        return np.dot(weights, torques), np.dot(weights, flat).reshape(readings[0].shape), time
