"""What the torque observer says, as messages."""

import numpy as np

from estimation.dependencies import Validity
from estimation.observer_covariance import Uncertainty
from estimation.torque_observer import Estimate, TorqueObserver
from robot_model.messages import ExternalWrenches, FtPrediction, JointTorques


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
        wrench, subtree_wrench, covariance = e.wrench, e.subtree_wrench, u.wrench
        if not v.complete:
            valid = v.subtree[:, None]
            wrench, subtree_wrench = (
                np.where(valid, wrench, 0.0),
                np.where(valid, subtree_wrench, 0.0),
            )
            covariance = np.where(valid[:, :, None], covariance, 0.0)
        return ExternalWrenches(
            frame=self._frames,
            link=self._links,
            subtree=self._subtrees,
            point=self._points,
            wrench=wrench,
            covariance=covariance,
            valid=v.subtree,
            kind=self._kinds,
            subtree_wrench=subtree_wrench,
            subtree_valid=v.subtree,
            subtree_reasons=v.subtree_reasons,
        )

    def prediction(self, e: Estimate, v: Validity) -> FtPrediction:
        """Return predicted and measured readings, zero where they are invalid."""
        predicted, measured = e.predicted, e.measured
        if not v.complete:
            valid = v.prediction[:, None]
            predicted, measured = np.where(valid, predicted, 0.0), np.where(valid, measured, 0.0)
        return FtPrediction(
            predicted=predicted,
            measured=measured,
            valid=v.prediction,
            reasons=v.prediction_reasons,
        )
