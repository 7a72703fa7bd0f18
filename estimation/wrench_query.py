"""Any wrench of one sample, in any frame, orientation and point, with its covariance."""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np
import pinocchio as pin
from numpy.typing import ArrayLike

from estimation.contact_set import numbered
from estimation.dependencies import Validity
from estimation.found_wrenches import FoundWrench, FoundWrenches
from estimation.observer_covariance import ObserverNoise
from estimation.torque_observer import TorqueObserver
from robot_model.names import did_you_mean

Array = np.ndarray
NEGLIGIBLE = 1e-6  # N, N m, in a pattern of wrenches; those that count have about 1 N, 0.1 N m


class ToldWrench(NamedTuple):
    """A wrench [f m], N and N m, and what it is worth.

    The covariance is that of the errors of sensors, motion and model (``ObserverNoise``).
    It says nothing of what the sensors leave undecided among several contacts: any multiple
    of the ``undecided`` may be added to the wrench without any reading changing.
    """

    wrench: Array  # (6,)
    frame: str  # in which it is told
    covariance: Array  # (6, 6)
    undecided: Array  # (d, 6) patterns; none where the sensors decide the wrench


class WrenchQuery:
    """Answers what acts on what, in one sample of an observer, until its next step.

    ``contact:<frame>`` is what the world exerts there (``contact:<frame>_2`` for the second
    on a frame), ``subtree:<name>`` its net effect on a sub-tree, ``sensor:<name>`` a reading
    without its offset, ``joint:<name>`` what the joint's parent exerts on its child
    (Fumagalli, eqs. (3.4.6) and (3.4.7)), and ``link:<name>`` the sum of all wrenches on a
    link: those of joints, sensors and world, which move it and hold it against gravity,
    eqs. (3.4.4) and (3.4.5).

    Args:
        observer: Computes the sample anew.
        noise: Standard deviations of its channels and bodies.
        sample: Arguments of its step.
        source: As in ``propagate``.
    """

    def __init__(
        self,
        observer: TorqueObserver,
        noise: ObserverNoise,
        *sample: Array,
        source: Array | None = None,
    ):
        self._found = found = FoundWrenches(observer, noise, sample, source)
        self.estimate, self._observer, robot = found.estimate, observer, observer.robot
        self._kinds: dict[str, tuple[Callable[[int], FoundWrench], list[str]]] = {
            "contact": (found.contact, numbered([c.frame for c in observer.contacts])),
            "subtree": (found.subtree, [subtree.name for subtree in robot.subtrees]),
            "sensor": (found.sensor, list(robot.ft_sensors)),
            "joint": (found.joint, list(robot.joints)),
            "link": (found.link, list(robot.urdf.links)),
        }

    def wrench(
        self, of: str, frame: str = "", axes: str = "", point: ArrayLike | None = None
    ) -> ToldWrench:
        """Return a wrench and its covariance.

        Args:
            of: ``kind:name``.
            frame: URDF link or frame about whose origin it is told; its own when empty.
            axes: URDF link or frame in whose axes it is told; ``frame`` when empty.
            point: (3,) m in ``frame``, instead of its origin.

        Raises:
            LookupError: Unknown kind, name or frame.
            ValueError: The point is not three finite numbers.
        """
        found = self._find(of)
        frame = frame or found.frame
        place = self._place(frame, axes, point).inverse() * found.place
        to = place.toDualActionMatrix()
        errors = to @ found.errors
        sizes = np.abs(found.patterns).max(axis=1, initial=0.0)
        undecided = found.patterns[sizes > NEGLIGIBLE] @ to.T
        return ToldWrench(to @ found.wrench, frame, errors @ errors.T, undecided)

    def why_invalid(self, validity: Validity, of: str, frame: str = "", axes: str = "") -> str:
        """Return what a wrench lacks in a sample of which not all is valid, "" for nothing.

        A link, and frame and axes in which a wrench is told, count as their sub-trees do;
        arguments as those of ``wrench``.
        """
        if validity.complete:
            return ""
        kind, row = self._row(of)
        own = {"joint": validity.torque_reasons, "sensor": validity.prediction_reasons}
        reasons = [own[kind][row]] if kind in own else []
        subtrees = [self._subtree(kind, row)] if kind not in own else []
        subtrees += [self._observer.robot.subtree_of(place) for place in (frame, axes) if place]
        reasons += [validity.subtree_reasons[i] for i in subtrees]
        return next(filter(None, reasons), "")

    def _subtree(self, kind: str, row: int) -> int:
        """Index of the sub-tree of a contact or a link, or itself."""
        if kind == "contact":
            return self._observer.contacts[row].subtree
        if kind == "link":
            return self._observer.robot.subtree_of(self._kinds[kind][1][row])
        return row

    def _row(self, of: str) -> tuple[str, int]:
        kind, _, name = of.partition(":")
        if kind not in self._kinds:
            kinds = ", ".join(self._kinds)
            raise LookupError(f"expected KIND:NAME, KIND one of {kinds}, got '{of}'")
        names = self._kinds[kind][1]
        if name not in names:
            raise LookupError(f"no {kind} '{name}'{did_you_mean(name, names)}")
        return kind, names.index(name)

    def _find(self, of: str) -> FoundWrench:
        kind, row = self._row(of)
        return self._kinds[kind][0](row)

    def _place(self, frame: str, axes: str, point: ArrayLike | None) -> pin.SE3:
        place = self._found.place(frame)
        if point is not None:
            place = place * pin.SE3(np.eye(3), _finite(point))
        if axes:
            place = pin.SE3(self._found.place(axes).rotation, place.translation)
        return place


def _finite(point: ArrayLike) -> Array:
    array = np.asarray(point, dtype=float)
    if array.shape != (3,) or not np.isfinite(array).all():
        raise ValueError(f"a point is three finite numbers [m], got {point}")
    return array
