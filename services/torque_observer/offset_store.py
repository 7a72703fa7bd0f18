"""Offsets that tares have found, in one file per robot: kept, listed, chosen."""

from pathlib import Path
from typing import Annotated, Literal

from pydantic import Field

from robot_model import Robot
from robot_model.dated_store import DatedFile, DatedRecord, DatedStore, StoreError, state_folder

Wrench = Annotated[list[float], Field(min_length=6, max_length=6)]  # N, N m


class TareRecord(DatedRecord):
    """One tare: when and how it was made, and what it found."""

    stance: str
    samples: int = Field(ge=1)
    posture: dict[str, float]  # rad, by joint
    offset: dict[str, Wrench]  # reading minus true wrench, by sensor, in its frame
    spread: dict[str, Wrench]  # standard deviation of the readings

    def check(self, robot: Robot) -> None:
        """Refuse offsets of another robot or model.

        Raises:
            StoreError: Says whose they are.
        """
        super().check(robot)
        if set(self.offset) != set(robot.ft_sensors):
            raise StoreError(
                f"the offsets of {self.date} are of the sensors {', '.join(self.offset)}; "
                f"{robot.name} has {', '.join(robot.ft_sensors)}"
            )


class TareFile(DatedFile):
    """The whole file, oldest tare first."""

    version: Literal[1] = 1
    tares: list[TareRecord] = []


class OffsetStore(DatedStore[TareFile, TareRecord]):
    """The tares of one robot.

    Args:
        robot: Whose offsets; the file bears its name.
        kept: Number of tares after which the oldest goes.
        folder: Where the file is; the user's state folder when left out.
    """

    def __init__(self, robot: Robot, kept: int, folder: Path | None = None):
        path = (folder or state_folder("tares")) / f"{robot.name}.json"
        super().__init__(robot, kept, path, TareFile, "tares", "tare")
