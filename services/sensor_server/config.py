"""Settings of the sensor server."""

from typing import Literal

from pydantic import BaseModel, ConfigDict, Field

from robot_model.service_config import RobotServiceConfig
from services.sensor_server.replay_config import ReplayConfig


class BoundConfig(BaseModel):
    """How far a sample may lie from the fit, by kind of channel."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    position: float = Field(default=1e-4, gt=0.0)  # rad
    torque: float = Field(default=0.4, gt=0.0)  # N m
    force: float = Field(default=1.0, gt=0.0)  # N
    moment: float = Field(default=0.04, gt=0.0)  # N m
    gyro: float = Field(default=0.02, gt=0.0)  # rad/s
    acceleration: float = Field(default=0.08, gt=0.0)  # m/s^2


class AdaptiveConfig(BaseModel):
    """The adaptive window; see ``AdaptiveWindow``."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    order: Literal[1, 2] = 2
    shortest: float = Field(default=0.003, gt=0.0, le=0.5)  # s
    bound: BoundConfig = BoundConfig()


class KalmanConfig(BaseModel):
    """The Kalman filter; see ``KalmanWindow``."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    noise: float = Field(default=2.8e-5, gt=0.0)  # rad
    jerk: float = Field(default=10.0, gt=0.0)  # rad/s^3 per root of Hz
    memory: float = Field(default=0.048, gt=0.0, le=2.0)  # s


class FilterConfig(BaseModel):
    """The filter through which all channels go when the driver gives positions only."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    method: Literal["triweight", "adaptive", "kalman"] = "triweight"
    delay: float = Field(default=0.024, ge=0.002, le=0.5)  # s
    bridge: float = Field(default=0.005, ge=0.0, le=0.1)  # s
    adaptive: AdaptiveConfig = AdaptiveConfig()
    kalman: KalmanConfig = KalmanConfig()


class CommandConfig(BaseModel):
    """Time limits of commands and feed-forward."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    lease: float = Field(default=0.5, gt=0.0)  # s
    command_timeout: float = Field(default=0.05, gt=0.0)  # s
    feedforward_timeout: float = Field(default=0.05, gt=0.0)  # s
    feedforward_fade: float = Field(default=0.5, gt=0.0)  # s
    rate: float = Field(default=200.0, gt=0.0)  # Hz


class SensorServerConfig(RobotServiceConfig):
    """Settings of the sensor server; ``config.yaml`` gives reasons."""

    driver: str = "plant"
    rate: float = Field(default=1000.0, gt=0.0)  # Hz
    filter: FilterConfig = FilterConfig()
    command: CommandConfig = CommandConfig()
    replay: ReplayConfig = ReplayConfig()
    inputs: dict[str, str] = {}
