"""Settings of the torque observer."""

from pydantic import BaseModel, ConfigDict, Field

from robot_model.service_config import RobotServiceConfig


class NoiseConfig(BaseModel):
    """Standard deviations of the sensor frame's channels."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    force: float = Field(default=0.3, gt=0.0)  # N
    moment: float = Field(default=0.02, gt=0.0)  # N m
    acceleration: float = Field(default=0.05, gt=0.0)  # m/s^2
    angular_acceleration: float = Field(default=0.15, gt=0.0)  # rad/s^2


class SourceNoiseConfig(BaseModel):
    """Standard deviations by which several kinematic sources are weighted."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    gyro: float = Field(default=0.005, gt=0.0)  # rad/s
    acceleration: float = Field(default=0.025, gt=0.0)  # m/s^2
    angular_acceleration: float = Field(default=0.05, gt=0.0)  # rad/s^2
    joint_velocity: float = Field(default=3e-4, ge=0.0)  # rad/s
    joint_acceleration: float = Field(default=0.05, ge=0.0)  # rad/s^2


class TareConfig(BaseModel):
    """When the robot rests, and how offsets are shared out."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    joint_velocity: float = Field(default=0.02, gt=0.0)  # rad/s
    joint_travel: float = Field(default=0.01, gt=0.0)  # rad
    angular_velocity: float = Field(default=0.05, gt=0.0)  # rad/s
    force_bias: float = Field(default=2.0, gt=0.0)  # N
    moment_bias: float = Field(default=0.06, gt=0.0)  # N m


class TorqueObserverConfig(RobotServiceConfig):
    """Settings of the torque observer; ``config.yaml`` gives reasons."""

    noise: NoiseConfig = NoiseConfig()
    kinematic_source: str = "first"
    fixed_link_gravity: tuple[float, float, float] = (0.0, 0.0, -9.81)  # m/s^2
    source_noise: SourceNoiseConfig = SourceNoiseConfig()
    uncertainty_period: float = Field(default=0.1, gt=0.0)  # s
    tare: TareConfig = TareConfig()
    inputs: dict[str, str] = {}
