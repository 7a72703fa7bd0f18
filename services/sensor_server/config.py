"""Settings of the sensor server."""

from typing import Any, ClassVar, Literal

import numpy as np
from pydantic import BaseModel, ConfigDict, Field, field_validator

from robot_model.service_config import RobotServiceConfig
from services.sensor_server.replay_config import ReplayConfig

Row = tuple[float, float, float, float, float, float]
IDENTITY: Any = tuple(tuple(float(i == j) for j in range(6)) for i in range(6))
WORST_CONDITION = 1e6  # no sensor's matrix is near it; forces and moments differ by 1e2


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


class FtSensorConfig(BaseModel):
    """Calibration of one force/torque sensor, in the axes and the sign of the driver's readings."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)

    matrix: tuple[Row, Row, Row, Row, Row, Row] = IDENTITY  # N, N m from N, N m
    temperature: Row = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0)  # N/K, N m/K
    reference: float = Field(default=25.0, ge=-50.0, le=150.0)  # degC

    @field_validator("matrix")
    @classmethod
    def _regular(cls, matrix: tuple[Row, ...]) -> tuple[Row, ...]:
        condition = np.linalg.cond(np.array(matrix))
        if condition > WORST_CONDITION:
            raise ValueError(f"expected a regular 6x6 matrix, got condition {condition:.1e}")
        return matrix


class FtConfig(BaseModel):
    """Calibration of the force/torque sensors, applied to what the driver delivers."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    sensors: dict[str, FtSensorConfig] = {}
    temperature_hold: float = Field(default=30.0, gt=0.0)  # s


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
    ft: FtConfig = FtConfig()
    command: CommandConfig = CommandConfig()
    replay: ReplayConfig = ReplayConfig()
    inputs: dict[str, str] = {}
    FIXED: ClassVar[tuple[str, ...]] = (
        *RobotServiceConfig.FIXED,
        "driver",
        "rate",
        "replay",
        "inputs",
    )
