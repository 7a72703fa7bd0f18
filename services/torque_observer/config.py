"""Settings of the torque observer."""

from typing import ClassVar, Self

from pydantic import BaseModel, ConfigDict, Field, model_validator

from estimation.drift_tracker import DriftLimits
from estimation.resting import StillnessLimits
from estimation.tare import OffsetLimits
from robot_model.service_config import RobotServiceConfig


class NoiseConfig(BaseModel):
    """Standard deviations of the sensor frame's channels, and of the model's bodies."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    force: float = Field(default=0.3, gt=0.0)  # N
    moment: float = Field(default=0.02, gt=0.0)  # N m
    acceleration: float = Field(default=0.05, gt=0.0)  # m/s^2
    angular_acceleration: float = Field(default=0.15, gt=0.0)  # rad/s^2
    angular_velocity: float = Field(default=0.01, ge=0.0)  # rad/s
    joint_velocity: float = Field(default=0.001, ge=0.0)  # rad/s
    joint_acceleration: float = Field(default=0.1, ge=0.0)  # rad/s^2
    mass: float = Field(default=0.02, ge=0.0)  # 1
    center_of_mass: float = Field(default=0.002, ge=0.0)  # m


class SourceNoiseConfig(BaseModel):
    """Standard deviations by which several kinematic sources are weighted."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    gyro: float = Field(default=0.005, gt=0.0)  # rad/s
    acceleration: float = Field(default=0.025, gt=0.0)  # m/s^2
    angular_acceleration: float = Field(default=0.05, gt=0.0)  # rad/s^2
    joint_velocity: float = Field(default=3e-4, ge=0.0)  # rad/s
    joint_acceleration: float = Field(default=0.05, ge=0.0)  # rad/s^2


class StillConfig(BaseModel):
    """A robot that exceeds one of these does not rest."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    joint_velocity: float = Field(default=0.02, gt=0.0)  # rad/s
    joint_travel: float = Field(default=0.01, gt=0.0)  # rad
    angular_velocity: float = Field(default=0.05, gt=0.0)  # rad/s
    force_spread: float = Field(default=3.0, gt=0.0)  # N
    moment_spread: float = Field(default=1.0, gt=0.0)  # N m

    def limits(self) -> StillnessLimits:
        """Return them as the estimation takes them."""
        return StillnessLimits(**self.model_dump())


class TareConfig(BaseModel):
    """How long a tare takes, when the robot rests, what is an offset, and what is kept."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    samples: int = Field(default=1000, ge=1, le=60_000)
    least_samples: int = Field(default=20, ge=1)
    still: StillConfig = StillConfig()
    force_bias: float = Field(default=2.0, gt=0.0)  # N
    moment_bias: float = Field(default=0.06, gt=0.0)  # N m
    largest_force: float = Field(default=40.0, gt=0.0)  # N
    largest_moment: float = Field(default=10.0, gt=0.0)  # N m
    load: bool = False
    kept: int = Field(default=20, ge=1, le=1000)

    def largest(self) -> OffsetLimits:
        """Return what is too large for an offset."""
        return OffsetLimits(self.largest_force, self.largest_moment)


class DriftConfig(BaseModel):
    """Whether and how fast offsets follow what untouched sensors show."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    follow: bool = False
    time_constant: float = Field(default=20.0, gt=0.0)  # s
    force_rate: float = Field(default=0.01, gt=0.0)  # N/s
    moment_rate: float = Field(default=3e-4, gt=0.0)  # N m/s
    force_gate: float = Field(default=1.5, gt=0.0)  # N
    moment_gate: float = Field(default=0.1, gt=0.0)  # N m
    largest_force: float = Field(default=5.0, gt=0.0)  # N
    largest_moment: float = Field(default=0.2, gt=0.0)  # N m
    settle: float = Field(default=2.0, gt=0.0)  # s

    def limits(self) -> DriftLimits:
        """Return them as the estimation takes them."""
        return DriftLimits(**self.model_dump(exclude={"follow"}))


class TorqueObserverConfig(RobotServiceConfig):
    """Settings of the torque observer; ``config.yaml`` gives reasons."""

    noise: NoiseConfig = NoiseConfig()
    kinematic_source: str = "first"
    fixed_link_gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)  # m/s^2
    source_noise: SourceNoiseConfig = SourceNoiseConfig()
    uncertainty_period: float = Field(default=0.1, gt=0.0)  # s
    tare: TareConfig = TareConfig()
    drift: DriftConfig = DriftConfig()
    follow_touches: bool = False
    inputs: dict[str, str] = {}
    FIXED: ClassVar[tuple[str, ...]] = (*RobotServiceConfig.FIXED, "follow_touches", "inputs")

    @model_validator(mode="after")
    def _repeatable(self) -> Self:
        if self.lockstep and self.drift.follow:
            raise ValueError("drift.follow: expected false in lockstep, whose runs must repeat")
        return self
