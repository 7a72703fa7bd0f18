"""Pose and velocity of the base from the inertial sensor, the encoders and the supports.

Tilt comes from the inertial sensor; heading, position and linear velocity from the legs:
a loaded support does not slip, and turns about its centre of pressure when it rocks. The
world's origin lies on the floor between the supports at the start, its x axis along
theirs. On the pole the base stays where it would be if the soles of the robot's home
posture hung ``pole_lift`` above that origin.
"""

import math
from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from estimation.attitude import AttitudeFilter, AttitudeGains, measured_up
from estimation.leg_odometry import LegOdometry, base_velocity, heading
from estimation.rotations import Quaternion, Rows, Vector, add, dot, rotate, rotate_back
from estimation.saturation import faults_by_name
from estimation.support_kinematics import FrameMotion, Support, SupportKinematics
from robot_model import Robot
from robot_model.messages import SensorFrame

GRAVITY = 9.81  # m/s^2
ZERO = (0.0, 0.0, 0.0)


@dataclass(frozen=True)
class BaseSettings:
    """Settings of the base estimator; the service's configuration gives reasons."""

    gains: AttitudeGains
    position_gain: float  # 1/s, pull of the footholds on the integrated position
    loaded_share: float  # of the robot's weight; a support that bears more does not slip
    pole_lift: float  # m
    position_std: float  # m
    tilt_std: float  # rad
    heading_std: float  # rad
    linear_std: float  # m/s
    angular_std: float  # rad/s


class BaseSample(NamedTuple):
    """One instant of the channels that the estimator needs."""

    q: np.ndarray  # (n,) rad
    dq: np.ndarray  # (n,) rad/s
    ft: np.ndarray  # (k, 6) parent on child, in the sensors' frames
    gyro: np.ndarray  # (3,) rad/s
    acc: np.ndarray  # (3,) m/s^2, proper
    quat_wxyz: np.ndarray | None  # (4,) R_world_imu up to heading, where the sensor gives it
    joint_valid: np.ndarray  # (n,)
    ft_valid: np.ndarray  # (k,)
    imu_valid: bool
    faults: Sequence[str] = ()  # of the sensor frame

    @classmethod
    def of(cls, frame: SensorFrame, use_orientation: bool = True) -> "BaseSample":
        """Return what a sensor frame tells; an invalid orientation, all zeros, is none."""
        quaternions = frame.imu_quat_wxyz if use_orientation else None
        if quaternions is not None and not quaternions[0].any():
            quaternions = None
        return cls(
            q=frame.q,
            dq=frame.dq,
            ft=frame.ft,
            gyro=frame.imu_gyro[0],
            acc=frame.imu_acc[0],
            quat_wxyz=None if quaternions is None else quaternions[0],
            joint_valid=frame.joint_valid,
            ft_valid=frame.ft_valid,
            imu_valid=bool(frame.imu_valid[0]),
            faults=frame.faults,
        )

    @property
    def orientation(self) -> Quaternion | None:
        return None if self.quat_wxyz is None else tuple(self.quat_wxyz.tolist())


class BaseEstimate(NamedTuple):
    """Pose and velocity of the base link."""

    position: np.ndarray  # (3,) m, in the world
    rotation: np.ndarray  # (3, 3) R_world_base
    twist: np.ndarray  # (6,) [v w], in base axes
    covariance: np.ndarray  # (12, 12) position and rotation in the world, twist in base axes
    reason: str  # why it is invalid; empty when it is valid


class BaseEstimator:
    """Complementary attitude filter and leg odometry.

    Args:
        robot: The robot; ``robot.supports[support]`` are the frames that may bear load.
        support: Kind of support. Where its frames hang on no sensor, the base is fixed.
        settings: Gains and stated uncertainties.

    Raises:
        LookupError: The robot has no such support.
    """

    def __init__(self, robot: Robot, support: str, settings: BaseSettings):
        self._robot = robot
        self._settings = settings
        self._limit = settings.loaded_share * robot.mass * GRAVITY  # N
        self._spread = _spread(settings)
        self._attitude = AttitudeFilter(settings.gains, GRAVITY)
        self._odometry = LegOdometry(settings.position_gain)
        self.set_support(support)

    def set_support(self, support: str) -> None:
        """Start anew on another kind of support."""
        if support not in self._robot.supports:
            exist = ", ".join(self._robot.supports)
            raise LookupError(f"no support '{support}'; there are: {exist}")
        self._kinematics = SupportKinematics(self._robot, self._robot.supports[support])
        self._fixed = self._kinematics.without_sensor
        self.reset()

    def reset(self) -> None:
        """Forget the past; the next complete sample starts a new world."""
        self._attitude.reset()
        self._odometry.reset()
        self._rotation: Rows = self._attitude.rotation  # R_world_base
        self._linear = self._angular = ZERO  # of the base, in its axes

    def step(self, sample: BaseSample, dt: float) -> BaseEstimate:
        """Advance by one sample, ``dt`` [s] after the last one."""
        if lost := self._lost(sample):
            return self._estimate(lost)
        self._kinematics.update(sample.q, sample.dq)
        imu = self._kinematics.imu()
        supports = self._supports(sample, imu)
        if not (supports or self._attitude.started):
            return self._estimate(self._no_support())
        if not self._attitude.started:
            self._start(sample, imu, supports)
        self._turn(sample, imu, supports, dt)
        self._move(sample, imu, supports, dt)
        return self._estimate("" if supports else self._no_support())

    def _lost(self, sample: BaseSample) -> str:
        if not sample.imu_valid:
            name = self._robot.imus[0]
            why = faults_by_name(sample.faults).get(name)
            return f"{name} is {why}" if why else f"no data from {name}"
        if all(sample.joint_valid.tolist()):
            return ""
        lost = self._kinematics.imu_joints & ~sample.joint_valid
        return f"no data from {self._robot.joints[int(lost.argmax())]}" if lost.any() else ""

    def _no_support(self) -> str:
        frames = self._kinematics.supports
        return f"none of {', '.join(frames)} bears load" if frames else "no support"

    def _supports(self, sample: BaseSample, imu: FrameMotion) -> dict[int, Support]:
        """Loaded supports, by their place among the frames."""
        kinematics = self._kinematics
        usable = kinematics.usable(sample.joint_valid, sample.ft_valid)
        if self._fixed:
            return {i: Support(kinematics.support(i), 1 / len(usable), ZERO) for i in usable}
        up = self._rotation[2]
        if not self._attitude.started:
            up = rotate(imu.rotation, measured_up(sample.acc.tolist()))
        motions = {i: kinematics.support(i) for i in usable}
        loads = {i: kinematics.load(i, motion, sample.ft) for i, motion in motions.items()}
        forces = {i: f for i, load in loads.items() if (f := dot(up, load.force)) > self._limit}
        total = sum(forces.values())
        return {
            i: Support(motions[i], force / total, loads[i].center) for i, force in forces.items()
        }

    def _start(self, sample: BaseSample, imu: FrameMotion, supports: dict[int, Support]) -> None:
        """Lay the world's origin between the supports, or the pole's base into the world."""
        self._attitude.start(measured_up(sample.acc.tolist(), sample.orientation))
        self._rotation = self._base_rotation(imu)
        motions = {i: support.motion for i, support in supports.items()}
        soles, lift = self._kinematics.soles, 0.0
        if self._fixed and (grounded := self._robot.supports.get("floor")):
            home = SupportKinematics(self._robot, grounded)
            home.update(self._robot.home, np.zeros(self._robot.n))
            motions = {i: home.support(i) for i in range(len(grounded))}
            soles, lift = home.soles, self._settings.pole_lift
        headings = [heading(self._rotation, motion) for motion in motions.values()]
        # The mean of unit vectors, because angles wrap.
        turn = -float(np.arctan2(np.sin(headings).sum(), np.cos(headings).sum()))
        self._attitude.turn_heading(turn)
        self._rotation = self._base_rotation(imu)
        self._odometry.start(_base_above(self._rotation, motions, soles, lift))

    def _base_rotation(self, imu: FrameMotion) -> Rows:
        return [rotate(imu.rotation, row) for row in self._attitude.rotation]

    def _turn(
        self, sample: BaseSample, imu: FrameMotion, supports: dict[int, Support], dt: float
    ) -> None:
        """Advance the attitude; the supports tell heading and, standing still, turning."""
        gyro, acc = sample.gyro.tolist(), sample.acc.tolist()
        error = self._odometry.heading_error(self._rotation, supports)
        self._attitude.update(gyro, acc, sample.orientation, dt, error)
        if supports:
            turning = imu.angular
            for motion, weight, _ in supports.values():
                turning = add(turning, motion.angular, -weight)
            self._attitude.learn_bias(gyro, rotate_back(imu.rotation, turning), dt)
        self._rotation = self._base_rotation(imu)

    def _move(
        self, sample: BaseSample, imu: FrameMotion, supports: dict[int, Support], dt: float
    ) -> None:
        """Advance velocity and position; without a load the last velocity is kept."""
        if not self._fixed:
            turning = rotate(imu.rotation, add(sample.gyro.tolist(), self._attitude.bias, -1.0))
            self._angular = add(turning, imu.angular, -1.0)
        if supports and not self._fixed:
            self._linear = base_velocity(self._angular, supports.values())
        self._odometry.update(self._rotation, self._linear, supports, dt)

    def _estimate(self, reason: str) -> BaseEstimate:
        return BaseEstimate(
            position=np.array(self._odometry.position),
            rotation=np.array(self._rotation),
            twist=np.array([*self._linear, *self._angular]),
            covariance=self._covariance(),
            reason=reason,
        )

    def _covariance(self) -> np.ndarray:
        """Stated variances; the tilt's begins larger and settles with the filter."""
        settling = math.exp(-self._settings.gains.tilt * max(self._attitude.age, 0.0))
        covariance = self._spread.copy()
        covariance[3, 3] = covariance[4, 4] = (
            self._settings.tilt_std * (1.0 + 2.0 * settling)
        ) ** 2
        return covariance


def _spread(s: BaseSettings) -> np.ndarray:
    """Variances (12, 12) with a settled tilt."""
    pose = [*3 * [s.position_std], s.tilt_std, s.tilt_std, s.heading_std]
    return np.diag(np.square([*pose, *3 * [s.linear_std], *3 * [s.angular_std]]))


def _base_above(
    rotation: Rows, motions: dict[int, FrameMotion], soles: list[np.ndarray | None], lift: float
) -> Vector:
    """Position of a base whose supports stand around the origin, ``lift`` above it."""
    middles = {i: np.zeros(3) if c is None else c.mean(axis=0) for i, c in enumerate(soles)}
    lowest = min(
        dot(rotation[2], add(motion.position, rotate(motion.rotation, middles[i].tolist())))
        for i, motion in motions.items()
    )
    x, y, _ = np.mean([rotate(rotation, m.position) for m in motions.values()], axis=0).tolist()
    return (-x, -y, lift - lowest)
