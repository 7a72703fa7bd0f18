"""Drift of the offsets, followed with the contact detector as witness; off unless asked for."""

from typing import Any

import numpy as np

from bus import Input, Received
from estimation.contact_set import support_by_subtree
from estimation.dependencies import Validity
from estimation.drift_tracker import DriftTracker
from estimation.torque_observer import Estimate, TorqueObserver
from services.torque_observer.config import DriftConfig


class Drift:
    """Adds what the tracker learns to the observer's offsets.

    Whoever else changes the offsets (a tare, a choice among stored ones) begins anew. A
    detector that is silent or invalid freezes everything.
    """

    def __init__(self, observer: TorqueObserver, contacts: Input, config: DriftConfig):
        self._observer, self._contacts = observer, contacts
        self.configure(config)

    def configure(self, config: DriftConfig) -> None:
        """Take new limits and the observer's present support."""
        self._limits = config.limits()
        self._begin()

    def follow(self, estimate: Estimate, validity: Validity, stamp: int) -> None:
        """Learn from a sample, as often as the detector says something."""
        received = self._contacts.newest()
        if received is None:
            return
        if self._observer.offset is not self._written:
            self._begin()
        residual = estimate.predicted - estimate.measured
        valid = validity.prediction & self._tared
        self._tracker.update(residual, self._untouched(received), valid, stamp)
        self._written = self._observer.offset = self._base + self._tracker.drift

    def status(self) -> dict[str, Any]:
        """Return what has been learnt since the last tare, and who is followed now."""
        names, tracker = self._observer.robot.ft_sensors, self._tracker
        fresh = self._contacts.fresh
        return {
            "drift": dict(zip(names, tracker.drift.tolist(), strict=True)),
            "followed": [names[i] for i in np.flatnonzero(tracker.followed)] if fresh else [],
        }

    def _begin(self) -> None:
        observer = self._observer
        self._base = self._written = observer.offset
        self._tared = bool(observer.offset.any())  # an untared sensor's bias is no drift
        supports = support_by_subtree(observer.robot, observer.support)
        self._tracker = DriftTracker(observer.graph, set(supports), self._limits)

    def _untouched(self, received: Received) -> np.ndarray:
        """Return the sub-trees of which the detector says that nothing touches them, (s,)."""
        free = set()
        if received.envelope.valid:
            flags = received.data.flags
            free = {f.get("limb") for f in flags if f.get("state") == "none" and f.get("valid")}
        return np.array([subtree.name in free for subtree in self._observer.robot.subtrees])
