"""The torque observer: sensor frames in, torques and wrenches out."""

import logging
from typing import Any

from bus import Node, Received
from bus.envelope import Envelope
from bus.paced import WAIT, Complaint
from estimation.torque_observer import TorqueObserver
from robot_model import Robot, load_robot, ports
from robot_model.messages import ContactPoints, Contacts, SensorFrame
from services.torque_observer.config import TorqueObserverConfig
from services.torque_observer.drift import Drift
from services.torque_observer.messages import touches
from services.torque_observer.observation import Observation
from services.torque_observer.outputs import Outputs
from services.torque_observer.tare_verbs import TareVerbs
from services.torque_observer.teller import Teller

logger = logging.getLogger(__name__)


def main(node: Node, config: TorqueObserverConfig) -> None:
    """Observe one robot until asked to stop."""
    service = ObserverService(node, load_robot(config.robot), config)
    node.ready()
    while node.running:
        service.spin()


class ObserverService:
    """Moves sensor frames to the observer, and what it finds to the ports."""

    def __init__(self, node: Node, robot: Robot, config: TorqueObserverConfig):
        self._node, self._robot, self._config = node, robot, config
        self._observer = TorqueObserver(robot, config.support)
        self._observation = Observation(self._observer, config)
        self._outputs = Outputs(node, self._observer)
        self._tares = TareVerbs(node, self._observer, config.tare)
        self._taring = self._tares.collecting
        self._complaint = Complaint(self._write_nothing)
        self._last: Envelope | None = None
        self._touch_error = ""
        self._teller = Teller(node)
        self._open_inputs()
        self._drift = self._open_drift() if config.drift.follow else None
        node.verb("status", self.status, help="state, contacts, offsets")
        node.verb("wrench", self.wrench, help="any wrench, in any frame, axes and point")
        node.parameters.on_change(self._configure)

    def _open_inputs(self) -> None:
        node, robot, sources = self._node, self._robot, self._config.inputs
        common: dict[str, Any] = {"model": robot.model_hash, "dimensions": robot.dimensions}
        self._sensors = node.input(
            ports.service_input(robot, node.name, "sensors"),
            SensorFrame,
            source=sources.get("sensors", ports.name("sensors", robot)),
            depth=64,
            rate=ports.rate("sensors"),
            **common,
        )
        points = ports.name("contact_points", robot)
        touches = ports.name("touch_points", robot) if self._config.follow_touches else ()
        self._points = node.input(points, ContactPoints, sources.get("contact_points", touches))

    def _open_drift(self) -> Drift:
        robot = self._robot
        contacts = self._node.input(
            ports.service_input(robot, self._node.name, "contacts"),
            Contacts,
            source=self._config.inputs.get("contacts", ports.name("contacts", robot)),
            rate=ports.rate("contacts"),
            model=robot.model_hash,
            wakes=False,
        )
        return Drift(self._observer, contacts, self._config.drift)

    def spin(self) -> None:
        """Wait for one frame at most, and answer all that came."""
        self._node.wait(WAIT)
        if (points := self._teller.news(self._points)) is not None:
            self._touch(points)
        while (sample := self._sensors.read()) is not None:
            self._observe(sample)
        if not self._sensors.fresh:
            self._complaint.make(self._sensors.reason)
        self._taring.watch()

    def _observe(self, sample: Received) -> None:
        frame, envelope = sample.data, sample.envelope
        if self._last is not None and envelope.stamp < self._last.stamp:
            self._taring.abandon("the clock jumped back")
        self._last = envelope
        if not envelope.valid:
            self._write_nothing(envelope.reason)
        else:
            self._tell(frame, envelope)
        self._node.acknowledge(envelope.stamp)

    def _tell(self, frame: SensorFrame, envelope: Envelope) -> None:
        """Write what a frame tells, and learn from it."""
        seen = self._observation
        estimate, validity = seen.observe(frame), seen.validity
        self._outputs.write(estimate, seen.uncertainty, validity, envelope)
        if self._drift is not None:
            self._drift.follow(estimate, validity, envelope.stamp)
        if self._taring.active and validity.complete and frame.imu_valid[0]:
            self._taring.add(frame, envelope.stamp)
        seen.age(envelope.stamp)

    def _write_nothing(self, reason: str) -> None:
        self._outputs.write_nothing(self._observation.uncertainty, reason, self._last)

    def _touch(self, points: ContactPoints) -> None:
        """Move the contacts; points that cannot be told apart leave them as they are."""
        try:
            self._observer.set_contacts(touches(points))
        except (LookupError, ValueError) as error:
            self._touch_error = str(error)
            logger.warning("%s: %s", self._points.name, error)
        else:
            self._touch_error = ""
            self._outputs.prepare()
            self._observation.follow_contacts()

    def _configure(self, old: TorqueObserverConfig, new: TorqueObserverConfig) -> None:
        if old.drift.follow != new.drift.follow:
            raise ValueError("drift.follow cannot be changed while the service runs")
        old.check_change(new)
        self._observation.configure(new)
        self._config = new
        self._tares.configure(new.tare)
        if new.support != old.support:
            self._taring.abandon(f"the support is now '{new.support}'")
            self._observer.set_contacts(support=new.support)
            self._outputs.prepare()
            self._observation.follow_contacts()
        if self._drift is not None:
            self._drift.configure(new.drift)

    def wrench(
        self, of: str, frame: str = "", axes: str = "", point: list[float] | None = None
    ) -> dict[str, Any]:
        """Return a wrench of the last sample with its covariance; see `WrenchQuery`."""
        query, last = self._observation.query(), self._last
        told = query.wrench(of, frame, axes, point)
        assert last is not None
        reason = last.reason or query.why_invalid(self._observation.validity, of, frame, axes)
        return {
            "of": of,
            "frame": told.frame,
            "axes": axes or told.frame,
            "point": point or [0.0, 0.0, 0.0],
            "force": told.wrench[:3].tolist(),
            "moment": told.wrench[3:].tolist(),
            "covariance": told.covariance.tolist(),
            "decided": not len(told.undecided),
            "undecided": told.undecided.tolist(),
            "stamp": last.stamp,
            "valid": last.valid and not reason,
            "reason": reason,
        }

    def status(self) -> dict[str, Any]:
        """Return the state of the service and what it assumes."""
        names = self._robot.ft_sensors
        contacts = [[c.frame, c.kind, *c.point.tolist()] for c in self._observer.contacts]
        return {
            **self._node.status(),
            "support": self._observer.support,
            "kinematic_source": self._observation.source,
            "contacts": contacts,
            "contact_error": self._touch_error,
            "offset": dict(zip(names, self._observer.offset.tolist(), strict=True)),
            "tare": self._tares.status(),
            "drift": self._drift.status() if self._drift else {"followed": []},
            "taring": self._taring.active,
        }
