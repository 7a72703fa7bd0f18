"""Settings of the contact detector."""

from typing import Annotated, ClassVar, Literal

from pydantic import BaseModel, ConfigDict, Field

from estimation.contact.contact_detector import DetectorSettings
from estimation.contact.limb_monitor import Levels
from estimation.contact.row_covariance import RowNoise
from estimation.residual.residual_bank import ResidualSettings
from robot_model.service_config import RobotServiceConfig

Gain = Annotated[float, Field(gt=0.0)]  # 1/s


class _Group(BaseModel):
    model_config = ConfigDict(extra="forbid", frozen=True)


class ResidualConfig(_Group):
    """Gains and thresholds of the residuals."""

    internal_gain: Gain = 25.0
    joint_gains: dict[str, Gain] = {}
    external_gain: Gain = 25.0
    classical: bool = False
    sigmas: float = Field(default=6.0, gt=0.0)
    internal_floor: float = Field(default=0.3, gt=0.0)  # N m
    force_floor: float = Field(default=2.0, gt=0.0)  # N
    moment_floor: float = Field(default=0.5, gt=0.0)  # N m
    longest_gap: float = Field(default=0.05, gt=0.0)  # s


class NoiseConfig(_Group):
    """Standard deviations of what the sensor frame carries, model errors included."""

    acceleration: float = Field(default=0.02, gt=0.0)  # m/s^2
    angular_acceleration: float = Field(default=0.15, gt=0.0)  # rad/s^2
    joint_acceleration: float = Field(default=0.08, gt=0.0)  # rad/s^2
    ft_force: float = Field(default=0.1, gt=0.0)  # N
    ft_moment: float = Field(default=0.01, gt=0.0)  # N m
    torque: float = Field(default=0.03, gt=0.0)  # N m
    friction: float = Field(default=0.3, ge=0.0)  # N m
    base_force: float = Field(default=0.3, gt=0.0)  # N
    base_moment: float = Field(default=0.05, gt=0.0)  # N m


class LevelConfig(_Group):
    """When a limb counts as touched."""

    contact: float = Field(default=6.5, gt=0.0)  # standard deviations
    margin: float = Field(default=1.5, ge=1.0)
    release: float = Field(default=0.6, gt=0.0, lt=1.0)
    release_time: float = Field(default=0.1, ge=0.0)  # s
    collision: float = Field(default=40.0, gt=0.0)  # N
    collision_release: float = Field(default=0.8, gt=0.0, le=1.0)


class TareConfig(_Group):
    """The automatic tare at the start."""

    window: float = Field(default=1.0, gt=0.1, le=30.0)  # s
    patience: float = Field(default=5.0, ge=0.0)  # s
    largest_bias: float = Field(default=8.0, gt=0.0)  # N


class CalibrationConfig(_Group):
    """What is kept of calibrations."""

    load: bool = True
    kept: int = Field(default=20, ge=1, le=1000)


class ContactDetectorConfig(RobotServiceConfig):
    """Settings of the contact detector; ``config.yaml`` gives reasons."""

    rate: float = Field(default=250.0, gt=0.0, le=1000.0)  # Hz
    locate_rate: float = Field(default=20.0, gt=0.0, le=250.0)  # Hz
    method: Literal["surface", "line", "particle"] = "surface"
    tell_points: bool = True
    model_error: float = Field(default=0.02, ge=0.0)
    gain_error: float = Field(default=0.02, ge=0.0)
    smoothing: float = Field(default=0.06, ge=0.001)  # s
    drift_time: float = Field(default=20.0, gt=0.0)  # s
    residuals: ResidualConfig = ResidualConfig()
    noise: NoiseConfig = NoiseConfig()
    levels: LevelConfig = LevelConfig()
    tare: TareConfig = TareConfig()
    calibration: CalibrationConfig = CalibrationConfig()
    inputs: dict[str, str] = {}
    FIXED: ClassVar[tuple[str, ...]] = (
        *RobotServiceConfig.FIXED,
        "inputs",
        "rate",
        "locate_rate",
    )

    def detector_settings(self) -> DetectorSettings:
        """Return the settings of the mathematics."""
        return DetectorSettings(
            noise=RowNoise(**self.noise.model_dump()),
            levels=Levels(**self.levels.model_dump()),
            model_error=self.model_error,
            gain_error=self.gain_error,
            smoothing=self.smoothing,
            drift_time=self.drift_time,
            method=self.method,
        )

    def residual_settings(self) -> ResidualSettings:
        """Return gains and thresholds of the residuals."""
        return ResidualSettings(**self.residuals.model_dump())
