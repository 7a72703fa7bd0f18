"""What services have learnt of a robot and keep: dated records in a file, one of them in use."""

import os
from datetime import UTC, datetime
from pathlib import Path
from typing import Generic, TypeVar

from pydantic import BaseModel, ConfigDict, ValidationError

from robot_model.names import did_you_mean
from robot_model.robot import Robot

LARGEST = 10_000_000  # bytes; what is larger is no file of ours


class StoreError(ValueError):
    """The file, or what was asked of it, cannot be used; the text says why."""


class Strict(BaseModel):
    """A part of the file; unknown keys and non-finite numbers are refused."""

    model_config = ConfigDict(extra="forbid", frozen=True, allow_inf_nan=False)


class DatedRecord(Strict):
    """Something learnt: when, and of which robot."""

    date: str  # UTC, ISO 8601; its name
    robot: str
    model: str  # short hash of the joints' names

    def check(self, robot: Robot) -> None:
        """Refuse what was learnt of another robot or model.

        Raises:
            StoreError: Says whose it is.
        """
        if (self.robot, self.model) != (robot.name, robot.model_hash):
            raise StoreError(
                f"what is of {self.date} is of robot {self.robot}, model {self.model}; "
                f"this is {robot.name}, model {robot.model_hash}"
            )


class DatedFile(Strict):
    """The whole file; a subclass has the list of records, oldest first."""

    in_use: str = ""  # date of the record in force; empty: none


Record = TypeVar("Record", bound=DatedRecord)
File = TypeVar("File", bound=DatedFile)


class DatedStore(Generic[File, Record]):
    """Reads and writes the records of one robot, whole or not at all.

    Args:
        robot: Whose.
        kept: Number of records after which the oldest goes.
        path: The file.
        file: Its type.
        key: Name of the list of records in it.
        noun: What a record is called in messages.
    """

    def __init__(self, robot: Robot, kept: int, path: Path, file: type[File], key: str, noun: str):
        self._robot, self.kept, self.path = robot, kept, path
        self._file, self._key, self._noun = file, key, noun

    def read(self) -> File:
        """Return what is stored, nothing when there is no file yet.

        Raises:
            StoreError: The file cannot be read, or is not one of these.
        """
        try:
            if self.path.stat().st_size > LARGEST:
                raise StoreError(f"{self.path}: expected at most {LARGEST} bytes")
            return self._file.model_validate_json(self.path.read_bytes())
        except FileNotFoundError:
            return self._file()
        except OSError as error:
            raise StoreError(f"{self.path}: {error.strerror}") from None
        except ValidationError as error:
            raise StoreError(f"{self.path}: {_first(error)}; move it away to start anew") from None

    def records(self) -> list[Record]:
        """Return the records, oldest first; see ``read``."""
        return getattr(self.read(), self._key)

    def find(self, date: str) -> Record:
        """Return the record of a date, or the only one whose date begins so.

        Raises:
            StoreError: None or several, or of another robot; or see ``read``.
        """
        dates = {record.date: record for record in self.records()}
        found = [date] if date in dates else [full for full in dates if full.startswith(date)]
        if len(found) != 1 or not date:
            near = f"; it may be {', '.join(found)}" if found else did_you_mean(date, dates)
            raise StoreError(f"expected the date of one {self._noun}, got '{date}'{near}")
        dates[found[0]].check(self._robot)
        return dates[found[0]]

    def add(self, record: Record) -> None:
        """Keep a record, which is in use from now on.

        Raises:
            StoreError: See ``read``; the file is left as it is.
        """
        known = [other for other in self.records() if other.date != record.date]
        self._write({"in_use": record.date, self._key: [*known, record][-self.kept :]})

    def use(self, date: str) -> None:
        """Remember which record is in force, by its whole date; empty for none."""
        self._write({"in_use": date})

    def forget(self, date: str) -> Record:
        """Remove the record of a date and return it; if it was in use, none is.

        Raises:
            StoreError: As ``find``.
        """
        record = self.find(date)
        left = [other for other in self.records() if other.date != record.date]
        in_use = self.read().in_use
        self._write({"in_use": "" if in_use == record.date else in_use, self._key: left})
        return record

    def _write(self, changes: dict[str, object]) -> None:
        content = self.read().model_copy(update=changes)
        fresh = self.path.with_name(f".{self.path.name}.{os.getpid()}")
        try:
            self.path.parent.mkdir(parents=True, exist_ok=True)
            fresh.write_text(content.model_dump_json(indent=1))
            fresh.replace(self.path)
        except OSError as error:
            fresh.unlink(missing_ok=True)
            raise StoreError(f"{self.path}: {error.strerror}") from None


def state_folder(name: str) -> Path:
    """Return ``$XDG_STATE_HOME/wrenchbus/<name>``, by default below ``~/.local/state``."""
    home = os.environ.get("XDG_STATE_HOME") or Path.home() / ".local" / "state"
    return Path(home) / "wrenchbus" / name


def date_of_now() -> str:
    """Return the present date as the files write it."""
    return datetime.now(UTC).isoformat(timespec="microseconds").replace("+00:00", "Z")


def _first(error: ValidationError) -> str:
    item = error.errors()[0]
    where = ".".join(map(str, item["loc"])) or "the file"
    return f"{where}: {item['msg'].lower()}"
