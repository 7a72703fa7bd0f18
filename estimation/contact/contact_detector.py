"""Contact detector: flags per limb and places, from sensor frames alone."""

from dataclasses import dataclass, field
from math import exp

import numpy as np

from estimation.contact.calibrator import Calibrator
from estimation.contact.contact_calibration import ContactCalibration
from estimation.contact.contact_rows import ContactRows
from estimation.contact.limb_monitor import Levels, LimbFlag, LimbMonitor
from estimation.contact.localisation import Localisation
from estimation.contact.quiet_period import Quiet
from estimation.contact.row_covariance import RowNoise
from estimation.contact.row_statistics import RowStatistics
from estimation.contact.support_watch import SupportWatch
from estimation.contact.touch_locator import Look, TouchLocator
from estimation.saturation import faults_by_name
from robot_model import Robot
from robot_model.messages import SensorFrame

Array = np.ndarray
BODY = "body"  # name of the flag of the whole body
CLEAR = 0.3  # s, time constant with which the clearest sign of a touch is forgotten


@dataclass(frozen=True)
class DetectorSettings:
    """Times in seconds."""

    noise: RowNoise = field(default_factory=RowNoise)
    levels: Levels = field(default_factory=Levels)
    model_error: float = 0.02  # part of a change of the predicted rows that may be wrong
    gain_error: float = 0.02  # likewise of a change of what force/torque sensors read
    covariance_time: float = 0.1  # how long a covariance is used
    smoothing: float = 0.06  # time constant of the rows that a touch is located with
    drift_time: float = 20.0  # time constant of the slow tare
    calm: float = 0.5  # fraction of every threshold below which the slow tare runs
    method: str = "surface"  # how touches are located: surface, line or particle


class ContactDetector:
    """Where a robot is touched, sample by sample.

    Uses the sensor frame only, never joint torques of the observer: those assume
    where the contact is. Untared until ``tare`` is called; the slow tare then follows
    drift while nothing touches.
    """

    def __init__(
        self, robot: Robot, support: str = "floor", settings: DetectorSettings | None = None
    ):
        self.robot = robot
        self.settings = settings or DetectorSettings()
        self.rows = ContactRows(robot, support)
        self._statistics = RowStatistics(self.rows, self.settings.noise)
        self.covariance = self._statistics.covariance
        self.locator = TouchLocator(
            self.rows, self.settings.noise, self.settings.smoothing, self.settings.method
        )
        self._supports = SupportWatch(robot, robot.supports[support])
        limbs = tuple(subtree.name for subtree in robot.subtrees)
        self.monitor = LimbMonitor(limbs, self.settings.levels)
        self.body_monitor = LimbMonitor((BODY,), self.settings.levels)
        self.calibration: ContactCalibration | None = None
        self._boundary = np.abs(self.rows.layout.incidence[:, 1:])
        nv = self.rows.layout.model.nv
        self._expected, self._carried = np.zeros(nv), np.zeros((len(robot.ft_sensors), 6))
        self._touch = np.zeros(nv)
        self.tared = False
        self.reset()

    def reset(self) -> None:
        """Forget contacts and filters, as after a jump of the stamps; the tare stays."""
        self._forget_contacts()
        self.locator.reset()
        self._supports.reset()
        self._stamp: int | None = None
        self._frame: SensorFrame | None = None  # of the last covariance
        self._shift: Array | float = 0.0  # of the readings from the covariance before to that one
        self._covariance_stamp = 0
        self._flags: tuple[object, ...] = ()
        self._clearest = 0.0  # statistic of the body, of late
        self._statistics.stop()

    def set_support(self, support: str) -> None:
        """Change the kind of support; the tare is lost with it."""
        self.rows.set_support(support)
        self._supports = SupportWatch(self.robot, self.robot.supports[support])
        self.tared = False
        self.rows.bias.reset()
        self.reset()

    def step(self, frame: SensorFrame, stamp: int) -> list[LimbFlag]:
        """Take one sample and return the flag of every limb.

        Stamps rise; any spacing will do, four milliseconds are usual.
        """
        self._touch = touch = self.rows.update(frame)
        period = 0.0 if self._stamp is None else (stamp - self._stamp) * 1e-9
        self._stamp = stamp
        self._refresh(frame, stamp, period)
        # the wrenches of what is felt and of how it changes, in one go
        both = np.array((touch, self.locator.change(touch)))
        (statistic, change), (self.force, _) = self._statistics.limbs.evaluate(both)
        self.locator.add(touch, period, max(change.tolist()))
        told = statistic.tolist(), self.force.tolist()
        flags = self.monitor.update(*told, stamp, self._reasons)
        self.body = self._judge_body(touch, stamp, period)
        self.locator.keep(self.touched)
        if self.tared and self._is_calm(statistic):
            self.rows.bias.follow(touch, period / self.settings.drift_time)
        return flags

    def _judge_body(self, touch: Array, stamp: int, period: float) -> LimbFlag:
        found = self._statistics.body.evaluate(touch)
        self._clearest *= exp(-period / CLEAR)
        if found.statistic >= self._clearest:  # a touch that fades does not change its limb
            self._clearest, self._likeliest = found.statistic, found.subtree
        told = [found.statistic], [found.force]
        return self.body_monitor.update(*told, stamp, [self._body_reason])[0]

    def tare(self, quiet: Quiet) -> None:
        """Take the offsets and thresholds that a quiet period showed."""
        self.rows.bias.tare(quiet.rows, self.rows.removal(), self.rows.removed.active)
        self._expected[:], self._carried[:] = quiet.predictions.mean(axis=0), quiet.ft
        self.locator.reset()
        self.tared = True
        self._renew()
        self.monitor.learn(self._statistics.limbs.evaluate(quiet.spread)[0].max(axis=0))
        self.body_monitor.learn(self._statistics.body.of_rows(quiet.spread).max(keepdims=True))
        self._forget_contacts()

    def calibrate(self, motion: Quiet) -> ContactCalibration:
        """Learn floors and thresholds from a motion in which nothing touched, and use them."""
        self.use(None)
        levels = self.settings.levels
        calibrator = Calibrator(self.rows, self._statistics, self._model_error, levels)
        calibration = calibrator.learn(motion)
        self.use(calibration)
        return calibration

    def use(self, calibration: ContactCalibration | None) -> None:
        """Put floors and thresholds in force; None for those of the settings."""
        self.calibration = calibration
        self.rows.floor = None if calibration is None else calibration.floor
        limbs = len(self.monitor.limbs)
        self.monitor.calibrate(np.zeros(limbs) if calibration is None else calibration.threshold)
        body = 0.0 if calibration is None else calibration.body_threshold
        self.body_monitor.calibrate(np.array([body]))
        self._renew()

    def configure(self, settings: DetectorSettings) -> None:
        """Change times and levels; contacts and the tare stay."""
        self.settings = settings
        self.locator.configure(settings.smoothing, settings.method)
        self.monitor.configure(settings.levels)
        self.body_monitor.configure(settings.levels)

    @property
    def tared_rows(self) -> Array:
        """Rows of the last sample after the tare, (nv,)."""
        return self._touch

    @property
    def untared_rows(self) -> Array:
        """Rows of the last sample before the tare, (nv,)."""
        rows = self.rows
        return self._touch + rows.remove(rows.bias.value.copy(), rows.removed)

    @property
    def touched(self) -> list[int]:
        """Indices of the sub-trees that are touched now.

        When only the whole body shows a touch, that is the sub-tree which explains it best
        where it shows most.
        """
        touched = self.monitor.touched
        return touched or ([self._likeliest] if self.body_monitor.touched else [])

    def locate(self, frame: SensorFrame) -> Localisation:
        """Locate the touch of every touched limb, at the time of the last step.

        Call it at a steady rate while a limb is touched: what is held is known better
        with time.
        """
        return self.locator.search(self.look(frame))

    def look(self, frame: SensorFrame) -> Look:
        """Return what ``locator.search`` needs, which may run beside the next steps."""
        unjudged = [i for i, why in enumerate(self._reasons) if why]
        error = self._model_error(frame)
        return self.locator.look(frame, self.touched, unjudged, error, self._stamp or 0)

    def _model_error(self, frame: SensorFrame) -> Array:
        """What is proportional to masses and gains, of changes since the tare, (nv,).

        Until the next look readings may change as much as since the last one.
        """
        if not self.tared:
            return np.zeros_like(self._expected)
        error: Array = self.settings.model_error * (self.rows.predicted - self._expected)
        sensors = self.rows.layout.tree.cut_v
        read = self.settings.gain_error * (np.abs(frame.ft - self._carried) + self._shift)
        error[sensors] = np.hypot(error[sensors], read)
        return error

    def _refresh(self, frame: SensorFrame, stamp: int, period: float) -> None:
        """Renew covariance and validity when they are old or a channel came or went.

        The latter at once; what is old serves until the new is done, piece by piece.
        """
        flags = (
            frame.joint_valid.tobytes(),
            frame.ft_valid.tobytes(),
            frame.imu_valid.tobytes(),
            tuple(frame.faults),
        )
        changed = flags != self._flags
        outdated = changed or self.covariance.outdated(frame)
        if outdated or (stamp - self._covariance_stamp) * 1e-9 >= self.settings.covariance_time:
            self._flags, self._covariance_stamp = flags, stamp
            if changed:
                self._learn_validity(frame)
            self._shift = np.abs(frame.ft - self._frame.ft) if self._frame else 0.0
            self._frame = frame
            self._look_at_supports(frame, stamp)
            self._statistics.begin(frame, self._model_error(frame))
        # a step's share of the time, so that it ends before the next begins
        self._statistics.go_on(1.0 if outdated else period / self.settings.covariance_time)

    def _learn_validity(self, frame: SensorFrame) -> None:
        self._reasons = self._limb_reasons(frame)
        self._body_reason = self._why_no_body(frame)
        blind = set(self.rows.removed.subtrees)
        judged = [not why and i not in blind for i, why in enumerate(self._reasons)]
        self._judged = np.flatnonzero(judged)

    def _look_at_supports(self, frame: SensorFrame, stamp: int) -> None:
        unsteady = self._supports.look(frame.ft, frame.ft_valid, stamp)
        for i in self.rows.removed.subtrees:
            why = unsteady.get(i)
            self._reasons[i] = f"bears a support and {why}" if why else "bears a support"

    def _renew(self) -> None:
        """Compute at once what belongs to posture, validity, tare and calibration."""
        if self._frame is not None:
            self._statistics.renew(self._frame, self._model_error(self._frame))

    def _limb_reasons(self, frame: SensorFrame) -> list[str]:
        """Why each limb cannot be judged, "" if it can."""
        robot, layout = self.robot, self.rows.layout
        names = np.array([robot.imus[0], *robot.joints, *robot.ft_sensors])
        lost = ~np.concatenate((frame.imu_valid[:1], frame.joint_valid, frame.ft_valid))
        imu = np.ones((len(layout.needs), 1), dtype=bool)
        needed = np.hstack((imu, layout.needs, self._boundary > 0.0)) & lost
        why = faults_by_name(frame.faults)
        first = [str(names[row.argmax()]) if row.any() else "" for row in needed]
        return [f"{name} is {why.get(name, 'invalid')}" if name else "" for name in first]

    def _why_no_body(self, frame: SensorFrame) -> str:
        """A lost force/torque sensor only makes it less sensitive; a lost motion blinds it."""
        robot = self.robot
        names = np.array([robot.imus[0], *robot.joints])
        lost = np.flatnonzero(~np.concatenate((frame.imu_valid[:1], frame.joint_valid)))
        if not len(lost):
            return ""
        name = str(names[lost[0]])
        return f"{name} is {faults_by_name(frame.faults).get(name, 'invalid')}"

    def _is_calm(self, statistic: Array) -> bool:
        """Whether nothing is near its threshold and the feet stand well, so that drift is drift."""
        assert self._stamp is not None
        if self.touched or not len(self._judged) or not self._supports.is_steady(self._stamp):
            return False
        calm = statistic < self.settings.calm * self.monitor.threshold
        return bool(calm[self._judged].all())

    def _forget_contacts(self) -> None:
        self.monitor.reset()
        self.body_monitor.reset()
