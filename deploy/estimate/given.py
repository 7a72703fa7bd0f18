"""What the user gave to be estimated."""

from dataclasses import dataclass, field

from estimation.offline.sensor_log import SensorLog
from robot_model import Robot


@dataclass(frozen=True, eq=False)
class Given:
    """A log, and the robot as the log sees it.

    ``robot`` is rooted at the fixed link where that is the kinematic source, and is without
    drives where the torques are those of the links.
    """

    log: SensorLog
    robot: Robot
    warnings: list[str] = field(default_factory=list)
