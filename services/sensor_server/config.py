"""Settings of the sensor server."""

from pydantic import BaseModel, ConfigDict, Field

from robot_model.service_config import RobotServiceConfig
from services.sensor_server.replay_config import ReplayConfig


class FilterConfig(BaseModel):
    """The window through which all channels go when the driver gives positions only."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    delay: float = Field(default=0.024, ge=0.002, le=0.5)  # s
    bridge: float = Field(default=0.005, ge=0.0, le=0.1)  # s


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
