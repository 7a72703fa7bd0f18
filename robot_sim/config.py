"""Settings of the plant process."""

from typing import Literal

from pydantic import Field

from robot_model.service_config import RobotServiceConfig
from robot_sim.plant import Base, PlantConfig


class SimConfig(RobotServiceConfig):
    """See ``config.yaml`` for units and reasons."""

    base: Base = "free"
    profile: str = "ideal"
    scenario: str = "quiet"
    seed: int = Field(default=0, ge=0)
    pace: Literal["real_time", "fast"] = "real_time"
    speed: float = Field(default=1.0, ge=0.05, le=10.0)
    slow_start: float = Field(default=0.0, ge=0.0, le=60.0)
    burst: int = Field(default=10, ge=1, le=100)
    participants: list[str] = []
    paused: bool = False
    truth: bool = True
    inputs: dict[str, str] = {}
    plant: PlantConfig = PlantConfig(watchdog=True)
