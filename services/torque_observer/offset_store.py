"""Offsets that tares have found, in one file per robot: kept, listed, chosen."""

import os
from datetime import datetime
from pathlib import Path
from typing import Annotated, Literal

from pydantic import BaseModel, ConfigDict, Field, ValidationError

from robot_model import Robot
from robot_model.names import did_you_mean

Wrench = Annotated[list[float], Field(min_length=6, max_length=6)]  # N, N m
LARGEST = 10_000_000  # bytes; what is larger is no file of ours


class StoreError(ValueError):
    """The file, or what was asked of it, cannot be used; the text says why."""


class Strict(BaseModel):
    """A part of the file; unknown keys and non-finite numbers are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class TareRecord(Strict):
    """One tare: when and how it was made, and what it found."""

    date: str  # UTC, ISO 8601; its name
    robot: str
    model: str  # short hash of the joints' names
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
        if (self.robot, self.model) != (robot.name, robot.model_hash):
            raise StoreError(
                f"the offsets of {self.date} are of robot {self.robot}, model {self.model}; "
                f"this is {robot.name}, model {robot.model_hash}"
            )
        if set(self.offset) != set(robot.ft_sensors):
            raise StoreError(
                f"the offsets of {self.date} are of the sensors {', '.join(self.offset)}; "
                f"{robot.name} has {', '.join(robot.ft_sensors)}"
            )


class TareFile(Strict):
    """The whole file, oldest tare first."""

    version: Literal[1] = 1
    in_use: str = ""  # date of the tare in force; empty: none
    tares: list[TareRecord] = []


class OffsetStore:
    """Reads and writes the tares of one robot, whole or not at all.

    Args:
        robot: Whose offsets; the file bears its name.
        kept: Number of tares after which the oldest goes.
        folder: Where the file is; the user's state folder when left out.
    """

    def __init__(self, robot: Robot, kept: int, folder: Path | None = None):
        self._robot, self.kept = robot, kept
        self.path = (folder or state_folder()) / f"{robot.name}.json"

    def read(self) -> TareFile:
        """Return what is stored, nothing when there is no file yet.

        Raises:
            StoreError: The file cannot be read, or is not one of these.
        """
        try:
            if self.path.stat().st_size > LARGEST:
                raise StoreError(f"{self.path}: expected at most {LARGEST} bytes")
            return TareFile.model_validate_json(self.path.read_bytes())
        except FileNotFoundError:
            return TareFile()
        except OSError as error:
            raise StoreError(f"{self.path}: {error.strerror}") from None
        except ValidationError as error:
            raise StoreError(f"{self.path}: {_first(error)}; move it away to start anew") from None

    def find(self, date: str) -> TareRecord:
        """Return the tare of a date, or the only one whose date begins so.

        Raises:
            StoreError: None or several, or of another robot; or see ``read``.
        """
        dates = {tare.date: tare for tare in self.read().tares}
        found = [date] if date in dates else [full for full in dates if full.startswith(date)]
        if len(found) != 1 or not date:
            near = f"; it may be {', '.join(found)}" if found else did_you_mean(date, dates)
            raise StoreError(f"expected the date of one tare, got '{date}'{near}")
        dates[found[0]].check(self._robot)
        return dates[found[0]]

    def add(self, tare: TareRecord) -> None:
        """Keep a tare, which is in use from now on.

        Raises:
            StoreError: See ``read``; the file is left as it is.
        """
        known = [other for other in self.read().tares if other.date != tare.date]
        self._write(TareFile(in_use=tare.date, tares=[*known, tare][-self.kept :]))

    def use(self, date: str) -> None:
        """Remember which tare is in force, by its whole date; empty for none."""
        self._write(self.read().model_copy(update={"in_use": date}))

    def _write(self, content: TareFile) -> None:
        fresh = self.path.with_name(f".{self.path.name}.{os.getpid()}")
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            fresh.write_text(content.model_dump_json(indent=1))
            fresh.replace(self.path)
        except OSError as error:
            fresh.unlink(missing_ok=True)
            raise StoreError(f"{self.path}: {error.strerror}") from None


def state_folder() -> Path:
    """Return ``$XDG_STATE_HOME/wrenchbus/tares``, by default below ``~/.local/state``."""
    home = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(home) / "wrenchbus" / "tares"


def date_of(stamp: datetime) -> str:
    """Return a date as the file writes it."""
    return stamp.isoformat(timespec="microseconds").replace("+00:00", "Z")


def _first(error: ValidationError) -> str:
    item = error.errors()[0]
    where = ".".join(map(str, item["loc"])) or "the file"
    return f"{where}: {item['msg'].lower()}"
