"""The offsets in force: found by a tare, chosen among stored ones, or reverted."""

import logging
from typing import Any

import numpy as np

from estimation.resting import RestingMean
from estimation.tare import TareResult
from estimation.torque_observer import TorqueObserver
from robot_model.dated_store import StoreError, date_of_now
from services.torque_observer.offset_store import OffsetStore, TareFile, TareRecord

logger = logging.getLogger(__name__)


class Offsets:
    """Changes the observer's offsets and remembers where they come from.

    A file that cannot be read or written costs the memory of the tares, never the tare: the
    offsets are in force all the same, and ``error`` says what is wrong.
    """

    def __init__(self, observer: TorqueObserver, store: OffsetStore):
        self._observer, self._store = observer, store
        self._robot = observer.robot
        self._past: list[tuple[np.ndarray, TareRecord | None]] = []
        self.record: TareRecord | None = None  # None: the offsets of the start, all zero
        self.loaded = "not asked for"  # what became of loading at the start
        self.error = ""

    def configure(self, kept: int) -> None:
        """Take a new number of tares that are kept."""
        self._store.kept = kept

    def load(self) -> None:
        """Put the stored offsets in force that were so last; never fails."""
        try:
            date = self._store.read().in_use
            if date:
                self._take(self._store.find(date))
            self.loaded = f"offsets of {date}" if date else "no tare is stored"
        except StoreError as error:
            self.loaded = f"refused: {error}"
            logger.warning("offsets not loaded: %s", error)

    def found(self, result: TareResult, rest: RestingMean, stance: str) -> TareRecord:
        """Put what a tare has found in force, and store it."""
        robot = self._robot
        record = TareRecord(
            date=date_of_now(),
            robot=robot.name,
            model=robot.model_hash,
            stance=stance,
            samples=rest.samples,
            posture=dict(zip(robot.joints, rest.q.tolist(), strict=True)),
            offset=dict(zip(robot.ft_sensors, result.offset.tolist(), strict=True)),
            spread=dict(zip(robot.ft_sensors, rest.spread.tolist(), strict=True)),
        )
        self._take(record)
        self._remember(lambda: self._store.add(record))
        return record

    def use(self, date: str) -> dict[str, Any]:
        """Put stored offsets in force.

        Raises:
            StoreError: No such tare, or of another robot.
        """
        record = self._store.find(date)
        self._take(record)
        self._remember(lambda: self._store.use(record.date))
        return self._answer(f"in use: {_describe(record)}")

    def revert(self) -> dict[str, Any]:
        """Put the offsets in force that were so before the last tare or choice.

        Raises:
            ValueError: Nothing has changed since the start.
        """
        if not self._past:
            raise ValueError("nothing to revert: no tare or choice since the service started")
        self._observer.offset, self.record = self._past.pop()
        self._remember(lambda: self._store.use(self.record.date if self.record else ""))
        return self._answer(f"back to {_describe(self.record)}")

    def listed(self) -> dict[str, Any]:
        """Return the stored tares, oldest first.

        Raises:
            StoreError: The file cannot be used.
        """
        content: TareFile = self._store.read()
        tares = [tare.model_dump() for tare in content.tares]
        return {
            "file": str(self._store.path),
            "in_use": self.record.date if self.record else "",
            "tares": tares,
            "message": "\n".join(map(_describe, content.tares)) or "no tare is stored",
        }

    def status(self) -> dict[str, Any]:
        """Return which offsets are in force, with their spread by sensor."""
        record = self.record
        return {
            "date": record.date if record else "",
            "stance": record.stance if record else "",
            "samples": record.samples if record else 0,
            "spread": record.spread if record else {},
            "loaded": self.loaded,
            "error": self.error,
        }

    def _take(self, record: TareRecord) -> None:
        self._past.append((self._observer.offset, self.record))
        del self._past[: -self._store.kept]
        self._observer.offset = np.array([record.offset[name] for name in self._robot.ft_sensors])
        self.record = record

    def _remember(self, write: Any) -> None:
        try:
            write()
            self.error = ""
        except StoreError as error:
            self.error = f"not stored: {error}"
            logger.warning("%s", self.error)

    def _answer(self, message: str) -> dict[str, Any]:
        names, offset = self._robot.ft_sensors, self._observer.offset.tolist()
        return {
            "in_use": self.record.date if self.record else "",
            "offset": dict(zip(names, offset, strict=True)),
            "message": f"{message}; {self.error}" if self.error else message,
        }


def _describe(record: TareRecord | None) -> str:
    if record is None:
        return "no offsets: the service has not been tared"
    return f"{record.date} {record.robot}, on {record.stance}, {record.samples} samples"
