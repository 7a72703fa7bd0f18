"""Inertial sensors: what each measures, and how well."""

from dataclasses import dataclass


@dataclass(frozen=True)
class InertialSensor:
    """An inertial sensor in the URDF frame of its name.

    What it does not measure is 0 in the frames, and nobody's to use.
    """

    name: str
    gyro: bool = True
    accelerometer: bool = True
    noise: float = 1.0  # its errors relative to those of profile and settings

    @property
    def complete(self) -> bool:
        """Whether it alone tells the motion of a link."""
        return self.gyro and self.accelerometer
