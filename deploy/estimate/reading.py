"""A recording or an npz, told apart by its first bytes."""

from pathlib import Path

from deploy.errors import UsageError
from deploy.estimate.given import Given
from deploy.estimate.npz_input import read_npz
from deploy.estimate.recording_input import read_recording
from robot_model import Robot

ZIP = b"PK"


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
        return read_npz(file, robot)
    return read_recording(file, robot)
