"""From a log to estimates: the live services' mathematics, sample by sample, without a bus."""

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from deploy.errors import CommandError, UsageError
from deploy.estimate.given import Given
from deploy.estimate.settings import Settings, default_settings
from estimation.base_estimator import BaseEstimator
from estimation.contact.contact_detector import ContactDetector
from estimation.contact_set import Touch
from estimation.observer_covariance import ObserverNoise
from estimation.offline.log_attitude import EstimatedUpward, GivenUpward
from estimation.offline.log_contacts import ContactLog, Upward
from estimation.offline.log_filter import LogFilter
from estimation.offline.log_observer import ObserverLog
from estimation.offline.log_saturation import without_saturated
from estimation.offline.log_tare import tare_observer
from estimation.offline.sensor_log import SensorLog
from estimation.residual.residual_bank import ResidualBank
from estimation.residual.residual_model import is_measured
from estimation.resting import TareError
from estimation.torque_observer import TorqueObserver
from robot_model.errors import DescriptionError

Progress = Callable[[int], None]  # gets the number of samples that are done


class Estimation:
    """The estimate of one log.

    Args:
        given: Log and robot.
        support: Kind of support.
        touches: Contacts in the place of the default ones.
        settings: The services' when None.

    Raises:
        UsageError: Unknown support or contact, or a log that is too short for the filter.
    """

    def __init__(
        self,
        given: Given,
        support: str,
        touches: Sequence[Touch] = (),
        settings: Settings | None = None,
    ):
        self.robot, self.support = given.robot, support
        self.log, saturated = without_saturated(given.log, given.robot)
        self._settings = settings or default_settings()
        try:
            self.observer = TorqueObserver(self.robot, support)
            self.observer.set_contacts(touches)
        except (LookupError, ValueError) as error:
            raise UsageError(str(error.args[0])) from None
        self._filter = self._filter_of(self.log)
        self._check_length()
        self.warnings = self._irregular()
        for sensor, count in saturated.items():
            self.warnings.append(f"{sensor}: saturated in {count} samples, which are invalid")
        size, config = len(self.log), self._settings.observer
        noise = ObserverNoise(**config.noise.model_dump())
        self.found = ObserverLog(self.observer, noise, size)
        self._length = max(1, round(config.uncertainty_period / self.log.period))
        self.contacts = None
        if self.log.motor_torque is not None:
            try:
                self.contacts = self._contacts()
            except DescriptionError as error:  # there are no meshes to find a touch on
                self.warnings.append(f"no residuals and contacts: {error}")

    def tare(self, seconds: float) -> str:
        """Take what the robot shows at the beginning for zero; return what was tared.

        Raises:
            CommandError: It moves then, or channels are missing.
        """
        end = self.log.stamp[0] + round(seconds * 1e9)
        if end > self.log.stamp[-1]:
            duration = float(self.log.stamp[-1] - self.log.stamp[0]) * 1e-9
            raise UsageError(f"tare: expected less than the log's {duration:g} s, got {seconds:g}")
        begin = self._filter_of(self.log.first(int(np.searchsorted(self.log.stamp, end))))
        config = self._settings.observer.tare
        limits = config.still.limits(), config.largest()
        bias = config.force_bias, config.moment_bias
        try:
            told = tare_observer(self.observer, begin.blocks(self._length), *limits, *bias)
            if self.contacts is not None:
                self.contacts.tare(begin.blocks(self._length))
        except TareError as error:
            raise CommandError(f"not tared in the first {seconds:g} s: {error}") from None
        return told.message

    def run(self, progress: Progress) -> None:
        """Estimate everything; see ``found`` and ``contacts``."""
        for block in self._filter.blocks(self._length):
            self.found.add(block)
            if self.contacts is not None:
                self.contacts.add(block)
            progress(block.rows.stop)

    def _filter_of(self, log: SensorLog) -> LogFilter:
        config = self._settings.filter
        return LogFilter(log, config.delay, config.bridge)

    def _check_length(self) -> None:
        kernel = self._filter.kernel
        if kernel is not None and len(self.log) < kernel.length:
            raise UsageError(
                f"{len(self.log)} samples are too few to estimate motion: expected"
                f" {kernel.length} or more, or dq, ddq and imu_dgyro beside them"
            )

    def _irregular(self) -> list[str]:
        breaks = self._filter.breaks
        if not len(breaks):
            return []
        where = f"{len(breaks)} gaps or odd steps of the stamps, first at index {breaks[0]}"
        side = 1e3 * self._filter.kernel.delay if self._filter.kernel else 0.0
        return [f"{where}: nothing is valid within {side:.3g} ms of each"]

    def _contacts(self) -> ContactLog:
        config, robot = self._settings.contacts, self.robot
        residuals = replace(config.residual_settings(), classical=True)
        return ContactLog(
            ContactDetector(robot, self.support, config.detector_settings()),
            ResidualBank(robot, self.support, residuals),
            len(self.log),
            config.rate,
            config.locate_rate,
            self._upward(),
        )

    def _upward(self) -> Upward | None:
        """Where up is, for the residual of a base whose support is not measured."""
        if is_measured(self.robot, self.support):
            return None
        if self.log.base_quat_wxyz is not None:
            return GivenUpward(self.log.base_quat_wxyz)
        config = self._settings.base
        estimator = BaseEstimator(self.robot, self.support, config.settings())
        every = max(1, round(1.0 / (config.rate * self.log.period)))
        return EstimatedUpward(estimator, self.log.stamp, every)
