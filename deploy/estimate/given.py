"""What the user gave to be estimated: a recording or an npz, told apart by their first bytes."""

from dataclasses import dataclass, field
from pathlib import Path

from deploy.errors import UsageError
from estimation.sensor_log import SensorLog
from robot_model import Robot

ZIP = b"PK"


@dataclass(frozen=True, eq=False)
class Given:
    """A log, and the robot as the log sees it.

    ``robot`` is rooted at the fixed link where that is the kinematic source, and is without
    drives where the torques are those of the links.
    """

    log: SensorLog
    robot: Robot
    warnings: list[str] = field(default_factory=list)


def read_input(file: Path, robot: Robot) -> Given:
    """Read a recording or an npz.

    Raises:
        UsageError: It does not exist, or something in it does not fit the robot.
        RecordingError: It is no npz, and no recording or a spoilt one.
    """
    try:
        with file.open("rb") as stream:
            zipped = stream.read(len(ZIP)) == ZIP
    except OSError as error:
        raise UsageError(f"{file}: {error.strerror}") from None
    if zipped or file.suffix == ".npz":
        from deploy.estimate.npz_input import read_npz

        return read_npz(file, robot)
    from deploy.estimate.recording_input import read_recording

    return read_recording(file, robot)
