"""The calibration in force: made from a motion, chosen among stored ones, or none."""

import logging
from typing import Any

from estimation.contact.contact_detector import ContactDetector
from estimation.contact.quiet_period import QuietPeriod
from robot_model.dated_store import StoreError, date_of_now
from services.contact_detector.calibration_store import (
    CalibrationRecord,
    CalibrationStore,
    calibration_of,
    record_of,
)
from services.contact_detector.config import CalibrationConfig

logger = logging.getLogger(__name__)
SHOWN = 1.01  # times its threshold of the settings from which a raised one is told


class Calibrations:
    """Changes the detector's floors and thresholds and remembers where they come from.

    A file that cannot be read or written costs the memory, never the calibration: it is in
    force all the same, and ``error`` says what is wrong.
    """

    def __init__(self, detector: ContactDetector, support: str, config: CalibrationConfig):
        self._detector, self._support = detector, support
        self._store = CalibrationStore(detector.robot, support, config.kept)
        self.record: CalibrationRecord | None = None
        self.loaded, self.error = "not asked for", ""
        if config.load:
            self._load()

    def _load(self) -> None:
        try:
            date = self._store.read().in_use
            if date:
                self._take(self._store.find(date))
            self.loaded = f"calibration of {date}" if date else "no calibration is stored"
        except StoreError as error:
            self.loaded = f"refused: {error}"
            logger.warning("calibration not loaded: %s", error)

    def finish(self, motion: QuietPeriod) -> dict[str, Any]:
        """Take floors and thresholds from a motion in which nothing touched, and keep them."""
        detector = self._detector
        found = detector.calibrate(motion.finish(still=False))
        record = record_of(found, detector.rows.layout, date_of_now(), self._support)
        self.record = record
        try:
            self._store.add(record)
            self.error = ""
        except StoreError as error:
            self.error = f"not stored: {error}"
            logger.warning("%s", self.error)
        told = f"calibrated: {self._describe(record)}"
        return self._answer(f"{told}; {self.error}" if self.error else told)

    def use(self, date: str) -> dict[str, Any]:
        """Put a stored calibration in force; "none" for the settings alone.

        Raises:
            StoreError: No such calibration, or of another robot.
        """
        if date == "none":
            self._drop()
            self._store.use("")
        else:
            self._take(self._store.find(date))
            self._store.use(self.record.date if self.record else "")
        return self._answer(f"in use: {self._describe(self.record)}")

    def forget(self, date: str) -> dict[str, Any]:
        """Remove a stored calibration; one that is in use is in use no more.

        Raises:
            StoreError: No such calibration.
        """
        forgotten = self._store.forget(date)
        if self.record is not None and self.record.date == forgotten.date:
            self._drop()
        return self._answer(f"forgotten: {forgotten.date}")

    def listed(self) -> dict[str, Any]:
        """Return the stored calibrations of this support, oldest first.

        Raises:
            StoreError: The file cannot be used.
        """
        stored = self._store.records()
        lines = "\n".join(map(self._describe, stored)) or "no calibration is stored"
        return {
            "file": str(self._store.path),
            "in_use": self.record.date if self.record else "",
            "calibrations": [record.model_dump() for record in stored],
            "message": lines,
        }

    def status(self) -> dict[str, Any]:
        """Return what is in force, and whether it was loaded."""
        date = self.record.date if self.record else ""
        return {"date": date, "loaded": self.loaded, "error": self.error}

    def _take(self, record: CalibrationRecord) -> None:
        self._detector.use(calibration_of(record, self._detector.rows.layout))
        self.record = record

    def _drop(self) -> None:
        self._detector.use(None)
        self.record = None

    def _answer(self, message: str) -> dict[str, Any]:
        record, monitor = self.record, self._detector.monitor
        thresholds = dict(zip(monitor.limbs, monitor.threshold.tolist(), strict=True))
        return {
            "date": record.date if record else "",
            "thresholds": thresholds,
            "body": float(self._detector.body_monitor.threshold[0]),
            "floors": {} if record is None else {"base": record.base, **record.torque, **record.ft},
            "samples": record.samples if record else 0,
            "message": message,
        }

    def _describe(self, record: CalibrationRecord | None) -> str:
        if record is None:
            return "none: thresholds and deviations of the settings"
        least = SHOWN * self._detector.settings.levels.contact
        raised = {**record.threshold, "body": record.body}
        texts = [f"{name} {value:.1f}" for name, value in raised.items() if value > least]
        floors = [f"{name} {value:.2f} N m" for name, value in record.torque.items() if value > 0.1]
        floors += [f"{n} {max(v[:3]):.1f} N" for n, v in record.ft.items() if max(v[:3]) > 0.1]
        return (
            f"{record.date} {record.robot}, on {record.support}, {record.samples} samples;"
            f" thresholds raised: {', '.join(texts) or 'none'};"
            f" floors: {', '.join(floors) or 'none'}"
        )
