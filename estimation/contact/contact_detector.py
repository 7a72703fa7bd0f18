"""Contact detector: flags per limb and places, from sensor frames alone."""

from dataclasses import dataclass, field

import numpy as np

from estimation.contact.contact_rows import ContactRows
from estimation.contact.limb_monitor import Levels, LimbFlag, LimbMonitor
from estimation.contact.localisation import Localisation
from estimation.contact.quiet_period import Quiet
from estimation.contact.row_covariance import RowCovariance, RowNoise
from estimation.contact.touch_locator import TouchLocator
from estimation.saturation import faults_by_name
from robot_model import Robot
from robot_model.messages import SensorFrame

Array = np.ndarray


@dataclass(frozen=True)
class DetectorSettings:
    """Times in seconds."""

    noise: RowNoise = field(default_factory=RowNoise)
    levels: Levels = field(default_factory=Levels)
    model_error: float = 0.02  # part of a change of the predicted rows that may be wrong
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
        self.covariance = RowCovariance(self.rows, self.settings.noise)
        self.locator = TouchLocator(
            self.rows, self.settings.noise, self.settings.smoothing, self.settings.method
        )
        limbs = tuple(subtree.name for subtree in robot.subtrees)
        self.monitor = LimbMonitor(limbs, self.settings.levels)
        self._boundary = np.abs(self.rows.layout.incidence[:, 1:])
        nv = self.rows.layout.model.nv
        self._offset, self._expected = np.zeros(nv), np.zeros(nv)
        self._touch = np.zeros(nv)
        self.tared = False
        self.wrenches = np.zeros((len(limbs), 6))  # tared; IMU axes, about its origin
        self.reset()

    def reset(self) -> None:
        """Forget contacts and filters, as after a jump of the stamps; the tare stays."""
        self.monitor.reset()
        self.locator.reset()
        self._stamp: int | None = None
        self._covariance_stamp = 0
        self._flags: tuple[object, ...] = ()

    def set_support(self, support: str) -> None:
        """Change the kind of support; the tare is lost with it."""
        self.rows.set_support(support)
        self.tared = False
        self._offset[:] = 0.0
        self.reset()

    def step(self, frame: SensorFrame, stamp: int) -> list[LimbFlag]:
        """Take one sample and return the flag of every limb.

        Stamps rise; any spacing will do, four milliseconds are usual.
        """
        raw = self.rows.update(frame)
        touch = np.subtract(raw, self._offset, out=self._touch)
        period = 0.0 if self._stamp is None else (stamp - self._stamp) * 1e-9
        self._stamp = stamp
        self.wrenches = wrenches = self.rows.wrenches(touch)
        self._refresh(frame, stamp)
        self.locator.add(touch, period, self._statistic)
        statistic = self._statistic(touch)
        force = np.sqrt(np.vecdot(wrenches[:, :3], wrenches[:, :3]))
        flags = self.monitor.update(statistic, force, stamp, self._reasons)
        self.locator.keep(self.touched)
        if self.tared and not self.touched:
            self._follow_drift(statistic, period)
        return flags

    def _statistic(self, touch: Array) -> Array:
        """Norm of each sub-tree's wrench in standard deviations, (s,)."""
        wrenches = self.rows.wrenches(touch)
        return np.sqrt(np.vecdot(wrenches, np.matvec(self._information, wrenches)))

    def tare(self, quiet: Quiet) -> None:
        """Take the offsets and thresholds that a quiet period showed."""
        self._offset[:] = quiet.rows
        self._expected[:] = quiet.predicted
        self.locator.reset()
        self.tared = True
        self.monitor.learn(quiet.statistics(self._information))
        self.monitor.reset()

    def calibrate(self, quiet: Quiet) -> dict[str, float]:
        """Raise the thresholds to what a motion without touches showed; returns them by limb."""
        error = quiet.wrenches - self.rows.wrenches(self._offset)
        squares = np.einsum("tsi,sij,tsj->ts", error, self._information, error)
        self.monitor.learn(np.sqrt(squares.max(axis=0)))
        return dict(zip(self.monitor.limbs, self.monitor.threshold.tolist(), strict=True))

    def configure(self, settings: DetectorSettings) -> None:
        """Change times and levels; contacts and the tare stay."""
        self.settings = settings
        self.locator.configure(settings.smoothing, settings.method)
        self.monitor.levels = settings.levels
        self.monitor.threshold = np.maximum(self.monitor.threshold, settings.levels.contact)

    @property
    def untared_rows(self) -> Array:
        """Rows of the last sample before the tare, (nv,)."""
        return self._touch + self._offset

    @property
    def touched(self) -> list[int]:
        """Indices of the sub-trees that are touched now."""
        return self.monitor.touched

    def locate(self, frame: SensorFrame) -> Localisation:
        """Locate the touch of every touched limb, at the posture of the last step.

        Call it at a steady rate while a limb is touched: what is held is known better
        with time. Probabilities of one limb sum to one with its share of none.
        """
        unjudged = [i for i, why in enumerate(self._reasons) if why]
        error = self._model_error()
        return self.locator.locate(frame, self.touched, unjudged, error, self._stamp or 0)

    def _model_error(self) -> Array:
        if not self.tared:
            return np.zeros_like(self._expected)
        return self.settings.model_error * (self.rows.predicted - self._expected)

    def _refresh(self, frame: SensorFrame, stamp: int) -> None:
        """Renew covariance and validity when they are old or a channel came or went."""
        flags = (
            frame.joint_valid.tobytes(),
            frame.ft_valid.tobytes(),
            frame.imu_valid.tobytes(),
            tuple(frame.faults),
        )
        age = (stamp - self._covariance_stamp) * 1e-9
        changed = flags != self._flags
        if not changed and age < self.settings.covariance_time:
            return
        self._flags, self._covariance_stamp = flags, stamp
        if changed:
            self._reasons = self._limb_reasons(frame)
            self._judged = np.flatnonzero([not reason for reason in self._reasons])
        self.covariance.update(frame, model_error=self._model_error())
        matrices = self.covariance.of_wrenches()
        # a support's own wrench has no error left, and is judged by its reason alone
        matrices[self.rows.removed.subtrees] = np.eye(6)
        self._information = np.linalg.inv(matrices)

    def _limb_reasons(self, frame: SensorFrame) -> list[str]:
        """Why each limb cannot be judged, "" if it can."""
        robot, layout = self.robot, self.rows.layout
        names = np.array([robot.imus[0], *robot.joints, *robot.ft_sensors])
        lost = ~np.concatenate((frame.imu_valid[:1], frame.joint_valid, frame.ft_valid))
        imu = np.ones((len(layout.needs), 1), dtype=bool)
        needed = np.hstack((imu, layout.needs, self._boundary > 0.0)) & lost
        why = faults_by_name(frame.faults)
        first = [str(names[row.argmax()]) if row.any() else "" for row in needed]
        reasons = [f"{name} is {why.get(name, 'invalid')}" if name else "" for name in first]
        for i in self.rows.removed.subtrees:
            reasons[i] = "bears a support"
        return reasons

    def _follow_drift(self, statistic: Array, period: float) -> None:
        """Let the offsets follow the rows slowly while nothing comes near its threshold."""
        calm = statistic < self.settings.calm * self.monitor.threshold
        if len(self._judged) and calm[self._judged].all():
            self._offset += (period / self.settings.drift_time) * self._touch
