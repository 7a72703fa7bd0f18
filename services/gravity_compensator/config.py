"""Settings of the gravity compensator."""

from typing import ClassVar

from pydantic import Field

from robot_model.service_config import RobotServiceConfig


class GravityCompensatorConfig(RobotServiceConfig):
    """Settings of the gravity compensator; ``config.yaml`` gives reasons."""

    rate: float = Field(default=100.0, gt=0.0, le=1000.0)  # Hz
    sharing_time: float = Field(default=0.25, ge=0.0)  # s
    inputs: dict[str, str] = {}
    FIXED: ClassVar[tuple[str, ...]] = (*RobotServiceConfig.FIXED, "inputs", "rate")
