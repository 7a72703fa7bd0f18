"""Settings of the base estimator."""

from typing import ClassVar

from pydantic import BaseModel, ConfigDict, Field

from estimation.attitude import AttitudeGains
from estimation.base_estimator import BaseSettings
from robot_model.service_config import RobotServiceConfig


class StdConfig(BaseModel):
    """Stated standard deviations."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    position: float = Field(default=0.005, gt=0.0)  # m
    tilt: float = Field(default=0.005, gt=0.0)  # rad
    heading: float = Field(default=0.01, gt=0.0)  # rad
    linear: float = Field(default=0.02, gt=0.0)  # m/s
    angular: float = Field(default=0.02, gt=0.0)  # rad/s


class BaseEstimatorConfig(RobotServiceConfig):
    """Settings of the base estimator; ``config.yaml`` gives reasons."""

    rate: float = Field(default=250.0, gt=0.0, le=1000.0)  # Hz
    use_orientation: bool = True
    tilt_gain: float = Field(default=0.5, gt=0.0)  # 1/s
    orientation_gain: float = Field(default=5.0, gt=0.0)  # 1/s
    heading_gain: float = Field(default=2.0, ge=0.0)  # 1/s
    bias_gain: float = Field(default=0.5, ge=0.0)  # 1/s
    acceleration_band: float = Field(default=2.0, gt=0.0)  # m/s^2
    position_gain: float = Field(default=2.0, ge=0.0)  # 1/s
    loaded_share: float = Field(default=0.1, gt=0.0, lt=1.0)
    pole_lift: float = Field(default=0.3, ge=0.0)  # m
    std: StdConfig = StdConfig()
    inputs: dict[str, str] = {}
    FIXED: ClassVar[tuple[str, ...]] = (*RobotServiceConfig.FIXED, "inputs", "rate")

    def settings(self) -> BaseSettings:
        """Return the settings of the mathematics."""
        return BaseSettings(
            gains=AttitudeGains(
                tilt=self.tilt_gain,
                orientation=self.orientation_gain,
                heading=self.heading_gain,
                bias=self.bias_gain,
                acceleration_band=self.acceleration_band,
            ),
            position_gain=self.position_gain,
            loaded_share=self.loaded_share,
            pole_lift=self.pole_lift,
            **{f"{name}_std": value for name, value in self.std.model_dump().items()},
        )
