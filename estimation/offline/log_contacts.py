"""Residuals and contacts over a log, as the contact detector says them live."""

from collections.abc import Callable, Iterable, Iterator
from itertools import repeat

import numpy as np

from estimation.contact.contact_detector import ContactDetector
from estimation.contact.localisation import NOWHERE, Localisation
from estimation.contact.quiet_period import QuietPeriod
from estimation.offline.sensor_log import SensorBlock
from estimation.residual.residual_bank import ResidualBank
from robot_model.messages import SensorFrame

Array = np.ndarray
Upward = Callable[[SensorFrame, int], Array | None]  # of a frame and its row: (3,) in base axes
AT_ONCE = -(1 << 62)  # ns, before every stamp
UNKNOWN = Localisation((), 0.0)
RESIDUALS = ("external", "internal", "classical")


class ContactLog:
    """Collects residuals and places of touches; T samples. Invalid entries are 0.0.

    Forces are integrated at every sample. As in the live detector, residuals and flags
    are computed at ``rate``, places at ``locate_rate``; in between the last ones hold.

    Args:
        detector, bank: The mathematics, of one robot and support.
        size: T, number of samples of the log.
        rate, locate_rate: Hz.
        upward: Tells where up is; None where the bank needs no attitude.
    """

    def __init__(
        self,
        detector: ContactDetector,
        bank: ResidualBank,
        size: int,
        rate: float = 250.0,
        locate_rate: float = 20.0,
        upward: Upward | None = None,
    ):
        self.detector, self.bank = detector, bank
        self._upward = upward or (lambda frame, row: None)
        self._period, self._locate_period = round(1e9 / rate), round(1e9 / locate_rate)
        self._next = self._next_location = AT_ONCE  # stamps, ns
        # what was said at the samples at which it was due; the row after the last says nothing
        self._residuals = np.zeros((size + 1, 6 + 2 * bank.robot.n))
        self._residuals_valid = np.zeros((size + 1, len(RESIDUALS)), dtype=bool)
        self._judged = np.zeros(size + 1, dtype=bool)
        self._place = np.zeros(size + 1, dtype=int)  # index in ``_found``
        self._found = [UNKNOWN, NOWHERE]
        self._due = np.full(size, size)  # row that holds at each sample
        self._said: list[int] = []  # rows of the present block at which something was due

    def tare(self, blocks: Iterable[SensorBlock]) -> None:
        """Take what a resting robot shows for zero, then forget the samples.

        Raises:
            MovingError: The robot moves, or channels are missing.
        """
        period = QuietPeriod(self.bank.robot.joints)
        for block in blocks:
            for _, frame, residuals in self._judge(block):
                if block.complete:
                    self._collect(period, frame, residuals)
        quiet = period.finish()
        self.detector.tare(quiet)
        self.bank.tare(quiet)
        self._restart()

    def add(self, block: SensorBlock) -> None:
        """Take some samples."""
        for row, frame, residuals in self._judge(block):
            self._residuals[row] = residuals - self.bank.offset
            self._residuals_valid[row] = self._residual_flags
            self._judged[row] = any(flag.valid for flag in self._flags)
            self._locate(frame, row)
            self._said.append(row)
        said, rows = np.array(self._said), np.arange(block.rows.start, block.rows.stop)
        self._due[block.rows] = said[np.searchsorted(said, rows, side="right") - 1]
        self._said = self._said[-1:]

    def _judge(self, block: SensorBlock) -> Iterator[tuple[int, SensorFrame, Array]]:
        """Yield row, frame and untared residuals of the samples at which flags were due."""
        for i, residuals, flags in self._residuals_of(block):
            frame, self._residual_flags = block.frame(i), flags
            self._stamp = int(block.stamp[i])
            self._flags = self.detector.step(frame, self._stamp)
            yield block.rows.start + i, frame, residuals

    def _residuals_of(self, block: SensorBlock) -> Iterable[tuple[int, Array, tuple[bool, ...]]]:
        due = self._due_in(block.stamp)
        if not (block.complete and self.bank.can_step_over(block.stamp)):
            return self._one_by_one(block, due)
        acting = block.motor_torque, block.ft, block.imu_gyro[:, 0], block.imu_acc[:, 0]
        motion, rows = (block.q, block.dq), np.array(due, dtype=int)
        torque = block.motor_torque_valid
        values = self.bank.step_over(block.stamp, acting, motion, rows, torque)
        return zip(due, values, repeat(self.bank.flags), strict=False)

    def _one_by_one(
        self, block: SensorBlock, due: list[int]
    ) -> Iterator[tuple[int, Array, tuple[bool, ...]]]:
        wanted, first = set(due), block.rows.start
        for i, stamp in enumerate(block.stamp.tolist()):
            frame = block.frame(i)
            self.bank.step(frame, stamp, self._upward(frame, first + i), i in wanted)
            if i in wanted:
                yield i, self.bank.values, self.bank.flags

    def _due_in(self, stamps: Array) -> list[int]:
        """Return the indices of the samples at which something is due."""
        due = []
        for i, stamp in enumerate(stamps.tolist()):
            if stamp >= self._next:
                due.append(i)
                self._next = max(self._next + self._period, stamp + self._period // 2)
        return due

    def _collect(self, period: QuietPeriod, frame: SensorFrame, residuals: Array) -> None:
        rows, untared = self.detector.rows, self.detector.untared_rows
        period.add(frame, untared, rows.predicted, rows.wrenches(untared), residuals)

    def _restart(self) -> None:
        self.detector.reset()
        self.bank.reset()
        self._next = AT_ONCE

    def _locate(self, frame: SensorFrame, row: int) -> None:
        if not self.detector.touched:
            self._next_location = AT_ONCE
            self._where = 1 if self._judged[row] else 0
        elif self._stamp >= self._next_location:
            self._found.append(self.detector.locate(frame))
            self._where = len(self._found) - 1
            self._next_location = self._stamp + self._locate_period
        self._place[row] = self._where

    def residual(self, name: str) -> tuple[Array, Array]:
        """Return a residual, (T, n) or external (T, 6), and where it is valid (T,)."""
        column, n = RESIDUALS.index(name), self.bank.robot.n
        columns = (slice(6), slice(6, 6 + n), slice(6 + n, None))[column]
        valid = self._residuals_valid[self._due, column]
        return np.where(valid[:, None], self._residuals[self._due, columns], 0.0), valid

    @property
    def valid(self) -> Array:
        """Whether any limb could be judged, (T,)."""
        return self._judged[self._due]

    def hypotheses(self, most: int = 3) -> dict[str, Array]:
        """Return the likeliest places of every sample, best first.

        ``probability`` (T, most); ``link`` (T, most) names, of several links that the data
        cannot tell apart the first, "" where there is no place; ``point`` [m] and ``force``
        [N] (T, most, 3) in the link's frame; ``none_probability`` (T,) that no touch explains
        the data, 1 without a touch, 0 where nothing is known.
        """
        size = len(self._found)
        probability, link = np.zeros((size, most)), [[""] * most for _ in range(size)]
        point, force = np.zeros((2, size, most, 3))
        for row, found in enumerate(self._found):
            for rank, one in enumerate(found.hypotheses[:most]):
                probability[row, rank], link[row][rank] = one.probability, one.links[0]
                point[row, rank], force[row, rank] = one.point, one.force
        tables = {"probability": probability, "link": np.array(link, dtype=str)}
        tables |= {"point": point, "force": force}
        tables["none_probability"] = np.array([found.none_probability for found in self._found])
        return {name: table[self._place[self._due]] for name, table in tables.items()}
