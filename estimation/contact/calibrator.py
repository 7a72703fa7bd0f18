"""Learns from a motion in which nothing touches how wrong a contact detector's rows are."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from estimation.contact.contact_calibration import ContactCalibration, likeliest_variances
from estimation.contact.contact_rows import ContactRows
from estimation.contact.limb_monitor import Levels
from estimation.contact.quiet_period import Quiet
from estimation.contact.row_statistics import RowStatistics
from robot_model.messages import SensorFrame

Array = np.ndarray
SHARES = (0.0, 0.25, 0.5, 1.0, 2.0, 4.0)  # of the likeliest floors, tried one after the other
MOVED = 0.01  # rad, least travel of a joint that shows how much friction it has
MOST, HARDEST = 400, 40  # stretches that are looked at, and those that choose the share
ALIKE = 1.05  # times the lowest statistic that can be reached
LONGEST = 25  # samples for which one covariance serves: 0.1 s at 250 Hz


class Stretch(NamedTuple):
    """Samples in about one posture."""

    frame: SensorFrame  # the first
    predicted: Array  # (nv,) by the model, at the first
    touches: Array  # (samples, nv)


class Calibrator:
    """Looks at every stretch of a motion in its own posture, as the detector does.

    Rows and statistics are left at the last stretch's posture, with the floors that were
    tried last.

    Args:
        rows: Of the detector.
        statistics: Likewise.
        model_error: Standard deviation of what the model predicts, (nv,), at a frame.
        levels: When a limb counts as touched.
    """

    def __init__(
        self,
        rows: ContactRows,
        statistics: RowStatistics,
        model_error: Callable[[SensorFrame], Array],
        levels: Levels,
    ):
        self._rows, self._statistics = rows, statistics
        self._model_error, self._levels = model_error, levels

    def learn(self, motion: Quiet) -> ContactCalibration:
        """Return floors and thresholds.

        Floors are the likeliest variances of the readings' errors row by row, of these the
        least share with which no threshold need be raised, or which more does not lower
        further. Those of joints that moved take the place of the friction that is expected
        otherwise.
        """
        stretches, fixed = self._stretches(motion)
        floors, margin = self._floors(motion.touches, fixed), self._levels.margin
        tried = [self._share(floors, share, motion.travel) for share in SHARES]
        floor = self._chosen(tried, stretches)
        limbs, body = self._largest(floor, stretches)
        return ContactCalibration(floor, margin * limbs, margin * body, len(motion.touches))

    def _chosen(self, floors: list[Array], stretches: list[Stretch]) -> Array:
        """Return the least floor that will do, judged where the least one does worst."""
        hardest = self._hardest(floors[0], stretches)
        highest: list[float] = []
        for floor in floors:
            limbs, body = self._largest(floor, hardest)
            highest.append(max(body, limbs.max()))
            if self._levels.margin * highest[-1] <= self._levels.contact:
                return floor
        good = np.array(highest) <= ALIKE * min(highest)
        return floors[int(good.argmax())]

    def _hardest(self, floor: Array, stretches: list[Stretch]) -> list[Stretch]:
        self._rows.floor = floor
        found = [self._judged(stretch) for stretch in stretches]
        order = np.argsort([-max(body, limbs.max()) for limbs, body in found], kind="stable")
        return [stretches[i] for i in order[:HARDEST]]

    def _stretches(self, motion: Quiet) -> tuple[list[Stretch], Array]:
        """Part a motion where the detector takes a new covariance.

        Returns the stretches, of many a part of them spread evenly, and the mean covariance
        of the active rows, (a, a), without what the readings' errors make of it.
        """
        frames, predicted = motion.frames, motion.predictions
        begins = self._begins(motion)
        touches = np.split(motion.touches, begins[1:])
        kept = np.unique(np.linspace(0, len(begins) - 1, MOST).round().astype(int))
        stretches = [
            Stretch(frames[k], predicted[k], t) for k, t in zip(begins, touches, strict=True)
        ]
        chosen = [stretches[i] for i in kept]
        self._rows.floor = np.zeros(motion.touches.shape[1])
        weights = [len(stretch.touches) for stretch in chosen]
        return chosen, np.average([self._fixed(each) for each in chosen], axis=0, weights=weights)

    def _begins(self, motion: Quiet) -> list[int]:
        """Samples with which stretches begin."""
        covariance, begins = self._statistics.covariance, [0]
        covariance.expect(motion.frames[0])
        for k, frame in enumerate(motion.frames):
            if k - begins[-1] == LONGEST or covariance.outdated(frame):
                begins.append(k)
                covariance.expect(frame)
        return begins

    def _fixed(self, stretch: Stretch) -> Array:
        covariance, active = self._statistics.covariance, self._rows.removed.active
        self._stand(stretch.frame, stretch.predicted)
        covariance.update(stretch.frame, model_error=self._model_error(stretch.frame))
        removal = self._rows.removal()[active]
        seen = (removal * covariance.variances) @ removal.T
        return covariance.matrix[np.ix_(active, active)] - seen

    def _floors(self, touches: Array, fixed: Array) -> Array:
        """Likeliest variances of the readings beyond those of the sensors, (nv,)."""
        active, least = self._rows.removed.active, self._statistics.covariance.variances
        rows, removal = touches[:, active], self._rows.removal()[active]
        moment = rows.T @ rows / len(rows)
        return likeliest_variances(moment, fixed, removal, least) - least

    def _share(self, floors: Array, share: float, travel: Array) -> Array:
        """A share of floors; of the joints' no less than all, which places depend on.

        A joint that rested tells nothing of its friction.
        """
        joints = self._rows.layout.tree.joint_v
        rested = joints[travel < MOVED]
        shared = share * floors
        shared[joints] = max(share, 1.0) * floors[joints]
        friction = self._statistics.covariance.noise.friction
        shared[rested] = shared[rested].clip(friction**2)
        return shared

    def _largest(self, floor: Array, stretches: list[Stretch]) -> tuple[Array, float]:
        """Largest statistic of every limb, (s,), 0 of a support's, and of the body."""
        self._rows.floor = floor
        found = [self._judged(stretch) for stretch in stretches]
        return np.max([limbs for limbs, _ in found], axis=0), max(body for _, body in found)

    def _judged(self, stretch: Stretch) -> tuple[Array, float]:
        statistics = self._statistics
        self._stand(stretch.frame, stretch.predicted)
        statistics.renew(stretch.frame, self._model_error(stretch.frame))
        limbs: Array = statistics.limbs.evaluate(stretch.touches)[0].max(axis=0)
        limbs[self._rows.removed.subtrees] = 0.0
        return limbs, float(statistics.body.of_rows(stretch.touches).max())

    def _stand(self, frame: SensorFrame, predicted: Array) -> None:
        self._rows.stand(frame)
        self._rows.predicted[:] = predicted
