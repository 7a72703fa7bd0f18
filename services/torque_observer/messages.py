"""What the torque observer says, as messages."""

from typing import Any

import numpy as np

from estimation.contact_set import Touch
from estimation.dependencies import Validity
from estimation.observer_covariance import Uncertainty
from estimation.torque_observer import Estimate, TorqueObserver
from robot_model.messages import ContactPoints, ExternalWrenches, FtPrediction, JointTorques


class Composer:
    """Makes messages of estimates; what belongs to the contacts is prepared once."""

    def __init__(self, observer: TorqueObserver):
        self._observer = observer
        self.prepare()

    def prepare(self) -> None:
        """Take the observer's contacts."""
        contacts = self._observer.contacts
        names = [subtree.name for subtree in self._observer.robot.subtrees]
        self._frames = [contact.frame for contact in contacts]
        self._links = [contact.link for contact in contacts]
        self._subtrees = [names[contact.subtree] for contact in contacts]
        self._points = np.array([contact.point for contact in contacts])
        self._kinds = [contact.kind for contact in contacts]
        self._rows = np.array([contact.subtree for contact in contacts], dtype=int)

    def torques(self, e: Estimate, u: Uncertainty, v: Validity) -> JointTorques:
        """Return the torques, zero where they are invalid."""
        if v.complete:
            return JointTorques(torque=e.torque, std=u.torque_std, valid=v.torque)
        return JointTorques(
            torque=np.where(v.torque, e.torque, 0.0),
            std=np.where(v.torque, u.torque_std, 0.0),
            valid=v.torque,
            reasons=v.torque_reasons,
        )

    def wrenches(self, e: Estimate, u: Uncertainty, v: Validity) -> ExternalWrenches:
        """Return the wrenches, zero where they are invalid."""
        wrench, covariance = e.wrench, u.wrench
        subtree_wrench, subtree_covariance = e.subtree_wrench, u.subtree_wrench
        valid = v.subtree[self._rows]
        if not v.complete:
            wrench = np.where(valid[:, None], wrench, 0.0)
            subtree_wrench = np.where(v.subtree[:, None], subtree_wrench, 0.0)
            covariance = np.where(valid[:, None, None], covariance, 0.0)
            subtree_covariance = np.where(v.subtree[:, None, None], subtree_covariance, 0.0)
        return ExternalWrenches(
            frame=self._frames,
            link=self._links,
            subtree=self._subtrees,
            point=self._points,
            wrench=wrench,
            covariance=covariance,
            valid=valid,
            kind=self._kinds,
            subtree_wrench=subtree_wrench,
            subtree_covariance=subtree_covariance,
            subtree_valid=v.subtree,
            subtree_reasons=v.subtree_reasons,
            **_decision(e, v.subtree),
        )

    def prediction(self, e: Estimate, u: Uncertainty, v: Validity) -> FtPrediction:
        """Return predicted and measured readings, zero where they are invalid."""
        predicted, measured, covariance = e.predicted, e.measured, u.prediction
        if not v.complete:
            valid = v.prediction[:, None]
            predicted, measured = np.where(valid, predicted, 0.0), np.where(valid, measured, 0.0)
            covariance = np.where(valid[:, None], covariance, 0.0)
        return FtPrediction(
            predicted=predicted,
            measured=measured,
            valid=v.prediction,
            covariance=covariance,
            reasons=v.prediction_reasons,
        )


def _decision(e: Estimate, valid: np.ndarray) -> dict[str, Any]:
    """Return how far the sensors decide the wrenches, where contacts share one."""
    if e.decision is None or e.unexplained is None:
        return {}
    return {
        "unexplained": np.where(valid[:, None], e.unexplained, 0.0),
        "rank": e.decision.rank,
        "condition": e.decision.condition,
        "undecided": e.decision.undecided,
        "decided": e.decision.decided.tolist(),
    }


def touches(points: ContactPoints) -> list[Touch]:
    """Return the touches that a message tells; raise ValueError when its lists differ in length."""
    count = len(points.link)
    unknown = points.unknown or ["wrench"] * count
    if len(unknown) != count or len(points.point) != count:
        raise ValueError(
            f"{count} links, {len(points.point)} points, {len(points.unknown)} kinds of unknowns;"
            " expected as many of each"
        )
    vectors = np.zeros((count, 6)) if points.vector is None else points.vector
    return [
        Touch(link, point, kind, vector[: 3 if kind == "direction" else 6])
        for link, point, kind, vector in zip(
            points.link, points.point, unknown, vectors, strict=True
        )
    ]
