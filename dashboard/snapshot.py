"""What the page knows at one moment."""

from dataclasses import dataclass

from robot_model.messages import (
    BaseState,
    ContactMap,
    Contacts,
    ExternalWrenches,
    GroundTruth,
    JointTorques,
    Residuals,
    SensorFrame,
)


@dataclass(frozen=True)
class Snapshot:
    """The newest message of each port; None where none is fresh and valid."""

    sensors: SensorFrame | None = None
    base: BaseState | None = None
    torques: JointTorques | None = None
    wrenches: ExternalWrenches | None = None
    residuals: Residuals | None = None
    contacts: Contacts | None = None
    contact_map: ContactMap | None = None
    truth: GroundTruth | None = None
