"""Settings of the recorder."""

from pydantic import Field

from robot_model.service_config import RobotServiceConfig


class RecorderConfig(RobotServiceConfig):
    """Settings of the recorder; ``config.yaml`` gives reasons."""

    folder: str = ""
    exclude: list[str] = []
    flush: float = Field(default=1.0, gt=0.0, le=10.0)  # s
    low_space: float = Field(default=2e9, ge=0.0)  # bytes
    least_space: float = Field(default=1e8, ge=0.0)  # bytes
