"""Covariance and statistics of the rows, renewed piece by piece while the posture changes."""

from collections.abc import Iterator
from math import ceil

import numpy as np

from estimation.contact.contact_rows import ContactRows
from estimation.contact.joint_statistic import PARTS, JointStatistic
from estimation.contact.limb_statistic import LimbStatistic
from estimation.contact.row_covariance import RowCovariance, RowNoise
from robot_model.messages import SensorFrame

Array = np.ndarray
PIECES = 2 + 1 + 1 + PARTS  # covariance, limbs, its inverse, bodies


class RowStatistics:
    """What belongs to posture, validity, tare and calibration.

    All of it takes longer than many steps of a detector, so that each step does a piece;
    what is old serves until the new is done.
    """

    def __init__(self, rows: ContactRows, noise: RowNoise):
        self.covariance = RowCovariance(rows, noise)
        self.limbs, self.body = LimbStatistic(rows), JointStatistic(rows)
        self.stop()

    def renew(self, frame: SensorFrame, model_error: Array) -> None:
        """Renew all at once, at the posture of the rows.

        Args:
            frame: Sensor frame of which the flags count.
            model_error: Standard deviation of what the model predicts, (nv,).
        """
        self.begin(frame, model_error)
        self.go_on(1.0)

    def begin(self, frame: SensorFrame, model_error: Array) -> None:
        """Begin a renewal; its posture is that of the first piece."""
        self._pending = self._pieces(frame, model_error)

    def go_on(self, share: float) -> None:
        """Do a share of a renewal, rounded up to whole pieces; nothing when it is done."""
        for _ in range(ceil(PIECES * min(share, 1.0))):
            next(self._pending, None)

    def stop(self) -> None:
        """Leave a renewal where it is."""
        self._pending: Iterator[None] = iter(())

    def _pieces(self, frame: SensorFrame, model_error: Array) -> Iterator[None]:
        yield from self.covariance.renewal(frame, model_error=model_error)
        yield
        self.limbs.update(self.covariance)
        yield
        yield from self.body.renewal(self.covariance)
