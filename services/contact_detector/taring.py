"""Quiet periods of the contact detector: at the start, and when somebody asks."""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from bus import Pending
from estimation.contact.contact_detector import ContactDetector
from estimation.contact.quiet_period import Quiet, QuietPeriod
from estimation.residual.residual_bank import ResidualBank
from estimation.resting import MovingError
from robot_model.messages import SensorFrame
from services.contact_detector.config import TareConfig

LONGEST = 120.0  # s
Finish = Callable[[QuietPeriod], dict[str, Any]]


@dataclass
class _Window:
    """One collection of samples, and whom to answer."""

    period: QuietPeriod
    length: int  # ns
    finish: Finish
    pending: Pending | None = None
    largest: float = np.inf  # N, more is a touch
    end: int | None = None  # stamp of the first sample plus length, ns
    force: float = 0.0  # N, largest on any limb


class Taring:
    """Collects samples for tares and calibrations, one after the other.

    Without a tare the biases of the sensors look like touches; so one is made at the
    start by itself. It waits for rest; when there is none, it takes a moving robot: the
    rows know the dynamics, only the model's own errors are then averaged in.
    """

    def __init__(self, detector: ContactDetector, bank: ResidualBank, config: TareConfig):
        self._detector, self._bank, self._config = detector, bank, config
        self._windows: list[_Window] = []
        self._since: int | None = None  # stamp of the first sample, ns
        self._now = 0
        self.waits = "waiting for its first tare"  # why not tared

    @property
    def busy(self) -> bool:
        """Whether samples are being collected."""
        return bool(self._windows)

    def request(self, seconds: float, finish: Finish, largest: float = np.inf) -> Pending:
        """Collect samples for some seconds, then answer with what ``finish`` makes of them.

        A force of more than ``largest`` [N] on a limb meanwhile is an error.
        """
        if not 0.1 <= seconds <= LONGEST:
            raise ValueError(f"seconds must lie between 0.1 and {LONGEST:g}, got {seconds}")
        if self._since is None:
            raise RuntimeError("no valid sensor frame has come")
        pending = Pending()
        self._add(seconds, finish, pending, largest)
        return pending

    def tare(self, period: QuietPeriod) -> dict[str, Any]:
        """Take offsets and thresholds; the answer says what was tared."""
        quiet = period.finish()
        limbs = [self._detector.monitor.limbs[i] for i in self._detector.touched]
        answer = self._take(quiet)
        if limbs:
            answer["message"] += f"; what touched {', '.join(limbs)} now counts as nothing"
        return answer

    def add(self, frame: SensorFrame, stamp: int) -> None:
        """Take the sample that the detector has just seen."""
        self._now = stamp
        if self._since is None or stamp < self._since:
            self._abandon("the stamps jumped back")
            self._since = stamp
        if not self._windows:
            if self._detector.tared:
                return
            self._add(self._config.window, self._start)
        self._collect(frame)
        for window in list(self._windows):
            if window.end is None:
                window.end = stamp + window.length
            elif stamp >= window.end:
                self._windows.remove(window)
                self._finish(window)

    def _add(
        self,
        seconds: float,
        finish: Finish,
        pending: Pending | None = None,
        largest: float = np.inf,
    ) -> None:
        period = QuietPeriod(self._detector.robot.joints)
        self._windows.append(_Window(period, round(seconds * 1e9), finish, pending, largest))

    def _collect(self, frame: SensorFrame) -> None:
        channels = (frame.joint_valid, frame.ft_valid, frame.imu_valid)
        if not all(flags.all() for flags in channels):
            return
        detector, rows = self._detector, self._detector.untared_rows
        wrenches, residuals = detector.rows.wrenches(rows), self._bank.values
        for window in self._windows:
            window.period.add(
                frame, rows, detector.rows.predicted, wrenches, residuals, detector.tared_rows
            )
            window.force = max(window.force, float(detector.force.max()))

    def _finish(self, window: _Window) -> None:
        try:
            if window.force > window.largest:
                raise MovingError(
                    f"{window.force:.1f} N on a limb are a touch (limit {window.largest:g} N)"
                )
            answer = window.finish(window.period)
        except MovingError as error:
            self.waits = f"not tared: {error}"
            if window.pending is not None:
                window.pending.fail(str(error))
        else:
            if window.pending is not None:
                window.pending.reply(answer)

    def _start(self, period: QuietPeriod) -> dict[str, Any]:
        waited = (self._now - (self._since or 0)) * 1e-9
        quiet = period.finish(still=waited < self._config.patience)
        force = np.linalg.norm(quiet.wrenches.mean(axis=0)[:, :3], axis=1)
        worst = int(force.argmax())
        if force[worst] > self._config.largest_bias:
            limb = self._detector.monitor.limbs[worst]
            raise MovingError(f"{force[worst]:.1f} N on {limb} is more than a bias")
        return self._take(quiet)

    def _take(self, quiet: Quiet) -> dict[str, Any]:
        detector = self._detector
        detector.tare(quiet)
        self._bank.tare(quiet)
        limbs, blind = detector.monitor.limbs, detector.rows.removed.subtrees
        tared = [limb for i, limb in enumerate(limbs) if i not in blind]
        unobservable = [limbs[i] for i in blind]
        offset = quiet.wrenches.mean(axis=0)
        message = f"tared: {', '.join(tared)}"
        if unobservable:
            message += f"; supports, whose wrench is not known: {', '.join(unobservable)}"
        return {
            "tared": tared,
            "unobservable": unobservable,
            "offset": {limbs[i]: offset[i].tolist() for i in range(len(limbs)) if i not in blind},
            "samples": quiet.samples,
            "message": message,
        }

    def _abandon(self, why: str) -> None:
        for window in self._windows:
            if window.pending is not None:
                window.pending.fail(why)
        self._windows.clear()
