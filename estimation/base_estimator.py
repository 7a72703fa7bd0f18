"""Pose and velocity of the base from the inertial sensor, the encoders and the supports.

Tilt comes from the inertial sensor; heading, position and linear velocity from the legs:
a loaded support does not slip, and turns about its centre of pressure when it rocks. The
world's origin lies on the floor between the supports at the start, its x axis along
theirs. On the pole the base stays where it would be if the soles of the robot's home
posture hung ``pole_lift`` above that origin.
"""

from dataclasses import dataclass

import numpy as np

from estimation.attitude import AttitudeFilter, AttitudeGains, measured_up
from estimation.leg_odometry import LegOdometry, base_velocity
from estimation.rotations import heading_of
from estimation.support_kinematics import FrameMotion, SupportKinematics
from robot_model import Robot

GRAVITY = 9.81  # m/s^2


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


@dataclass(frozen=True, eq=False)
class BaseSample:
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


@dataclass(frozen=True, eq=False)
class BaseEstimate:
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
        self._rotation, self._twist = np.eye(3), np.zeros(6)

    def step(self, sample: BaseSample, dt: float) -> BaseEstimate:
        """Advance by one sample, ``dt`` [s] after the last one."""
        if lost := self._lost(sample):
            return self._estimate(lost)
        kinematics = self._kinematics
        kinematics.update(sample.q, sample.dq)
        imu = kinematics.imu()
        weights, centers = self._loads(sample, imu)
        supports = {i: kinematics.support(i) for i in weights}
        if not (weights or self._attitude.started):
            return self._estimate(self._no_support())
        if not self._attitude.started:
            self._start(sample, imu, supports)
        self._turn(sample, imu, supports, weights, dt)
        self._move(sample, imu, supports, weights, centers, dt)
        return self._estimate("" if weights else self._no_support())

    def _lost(self, sample: BaseSample) -> str:
        if not sample.imu_valid:
            return f"no data from {self._robot.imus[0]}"
        lost = self._kinematics.imu_joints & ~sample.joint_valid
        return f"no data from {self._robot.joints[int(lost.argmax())]}" if lost.any() else ""

    def _no_support(self) -> str:
        frames = self._kinematics.supports
        return f"none of {', '.join(frames)} bears load" if frames else "no support"

    def _loads(
        self, sample: BaseSample, imu: FrameMotion
    ) -> tuple[dict[int, float], dict[int, np.ndarray]]:
        """Share of the load and centre of pressure of each loaded support."""
        kinematics = self._kinematics
        usable = np.flatnonzero(kinematics.usable(sample.joint_valid, sample.ft_valid))
        if self._fixed:
            share = 1.0 / max(1, usable.size)
            return {int(i): share for i in usable}, {int(i): np.zeros(3) for i in usable}
        up = self._rotation[2] if self._attitude.started else imu.rotation @ measured_up(sample.acc)
        limit = self._settings.loaded_share * self._robot.mass * GRAVITY
        loads = {int(i): kinematics.load(int(i), sample.ft) for i in usable}
        forces = {i: f for i, load in loads.items() if (f := float(up @ load.force)) > limit}
        total = sum(forces.values())
        weights = {i: force / total for i, force in forces.items()}
        return weights, {i: loads[i].center for i in forces}

    def _start(
        self, sample: BaseSample, imu: FrameMotion, supports: dict[int, FrameMotion]
    ) -> None:
        """Lay the world's origin between the supports, or the pole's base into the world."""
        self._attitude.start(measured_up(sample.acc, sample.quat_wxyz))
        self._rotation = self._attitude.rotation @ imu.rotation.T
        lift = 0.0
        if self._fixed and (grounded := self._robot.supports.get("floor")):
            home = SupportKinematics(self._robot, grounded)
            home.update(self._robot.home, np.zeros(self._robot.n))
            supports = {i: home.support(i) for i in range(len(grounded))}
            soles, lift = home.soles, self._settings.pole_lift
        else:
            soles = self._kinematics.soles
        headings = [heading_of(self._rotation @ s.rotation) for s in supports.values()]
        # The mean of unit vectors, because angles wrap.
        turn = -float(np.arctan2(np.sin(headings).sum(), np.cos(headings).sum()))
        self._attitude.turn_heading(turn)
        self._rotation = self._attitude.rotation @ imu.rotation.T
        self._odometry.start(_base_above(self._rotation, supports, soles, lift))

    def _turn(
        self,
        sample: BaseSample,
        imu: FrameMotion,
        supports: dict[int, FrameMotion],
        weights: dict[int, float],
        dt: float,
    ) -> None:
        """Advance the attitude; the supports tell heading and, standing still, turning."""
        error = self._odometry.heading_error(self._rotation, supports, weights)
        self._attitude.update(sample.gyro, sample.acc, sample.quat_wxyz, dt, error)
        if weights:
            turning = sum(weights[i] * support.angular for i, support in supports.items())
            reference = imu.rotation.T @ (imu.angular - turning)
            self._attitude.learn_bias(sample.gyro, reference, dt)
        self._rotation = self._attitude.rotation @ imu.rotation.T

    def _move(
        self,
        sample: BaseSample,
        imu: FrameMotion,
        supports: dict[int, FrameMotion],
        weights: dict[int, float],
        centers: dict[int, np.ndarray],
        dt: float,
    ) -> None:
        """Advance velocity and position; without a load the last velocity is kept."""
        if self._fixed:
            self._twist = np.zeros(6)
        else:
            self._twist[3:] = imu.rotation @ (sample.gyro - self._attitude.bias) - imu.angular
        if weights and not self._fixed:
            self._twist[:3] = base_velocity(self._twist[3:], supports, weights, centers)
        self._odometry.update(self._rotation, self._twist[:3], supports, weights, dt)

    def _estimate(self, reason: str) -> BaseEstimate:
        return BaseEstimate(
            position=self._odometry.position.copy(),
            rotation=self._rotation,
            twist=self._twist.copy(),
            covariance=self._covariance(),
            reason=reason,
        )

    def _covariance(self) -> np.ndarray:
        """Stated variances; the tilt's begins larger and settles with the filter."""
        s = self._settings
        settling = np.exp(-s.gains.tilt * max(self._attitude.age, 0.0))
        tilt = s.tilt_std * (1.0 + 2.0 * settling)
        stds = [*3 * [s.position_std], tilt, tilt, s.heading_std]
        return np.diag(np.square([*stds, *3 * [s.linear_std], *3 * [s.angular_std]]))


def _base_above(
    rotation: np.ndarray,
    supports: dict[int, FrameMotion],
    soles: list[np.ndarray | None],
    lift: float,
) -> np.ndarray:
    """Position (3,) of a base whose supports stand around the origin, ``lift`` above it."""
    origins = np.array([rotation @ support.position for support in supports.values()])
    lowest = min(
        float(origin[2] + ((corners @ support.rotation.T) @ rotation.T)[:, 2].mean())
        if (corners := soles[i]) is not None
        else float(origin[2])
        for (i, support), origin in zip(supports.items(), origins, strict=True)
    )
    middle = origins.mean(axis=0)
    return np.array([-middle[0], -middle[1], lift - lowest])
