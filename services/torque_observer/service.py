"""The torque observer: sensor frames in, torques and wrenches out."""

import logging
import time
from typing import Any

import numpy as np

from bus import Node, Received
from bus.envelope import Envelope
from estimation.dependencies import ChannelDependencies, Validity
from estimation.inertial_fusion import InertialNoise
from estimation.kinematic_source import FIRST, KinematicSource
from estimation.observer_covariance import ObserverNoise, propagate
from estimation.torque_observer import Estimate, TorqueObserver
from estimation.wrench_query import WrenchQuery
from robot_model import Robot, load_robot, ports
from robot_model.messages import (
    ContactPoints,
    Contacts,
    ExternalWrenches,
    FtPrediction,
    JointTorques,
    SensorFrame,
)
from services.torque_observer.config import TorqueObserverConfig
from services.torque_observer.drift import Drift
from services.torque_observer.messages import Composer, touches
from services.torque_observer.tare_verbs import TareVerbs
from services.torque_observer.teller import Teller

logger = logging.getLogger(__name__)

WAIT = 0.01  # s; silence is looked at this often
COMPLAINT = 0.02  # s between messages while the input is silent


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
        self._source = self._make_source(config)
        self._composer = Composer(self._observer)
        self._tares = TareVerbs(node, self._observer, config.tare)
        self._taring = self._tares.collecting
        self._last: Envelope | None = None
        self._sample: tuple[np.ndarray, ...] | None = None
        self._complained = 0.0  # s
        self._touch_error = ""
        self._teller = Teller(node)
        self._open_ports()
        self._drift = self._open_drift() if config.drift.follow else None
        self._follow_contacts()
        self._nothing = self._observer.step(*_still(robot))
        node.verb("status", self.status, help="state, contacts, offsets")
        node.verb("wrench", self.wrench, help="any wrench, in any frame, axes and point")
        node.parameters.on_change(self._configure)

    def _open_ports(self) -> None:
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
        sizes = {**common, "dimensions": {**robot.dimensions, "s": len(robot.subtrees)}}
        self._torques, self._wrenches, self._predictions = (
            node.output(ports.name(key, robot), kind, rate=ports.rate(key), **sizes)
            for key, kind in (
                ("torques", JointTorques),
                ("wrenches", ExternalWrenches),
                ("ft_prediction", FtPrediction),
            )
        )

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
            self._complain()
        self._taring.watch()

    def _observe(self, sample: Received) -> None:
        frame, envelope = sample.data, sample.envelope
        if self._last is not None and envelope.stamp < self._last.stamp:
            self._taring.abandon("the clock jumped back")
        self._last = envelope
        if not envelope.valid:
            self._write_nothing(envelope.reason)
        else:
            estimate, imu_valid = self._step(frame)
            validity = self._dependencies.validity(
                frame.joint_valid, frame.ft_valid, imu_valid, frame.faults
            )
            self._write(estimate, validity, envelope)
            self._validity = validity
            if self._drift is not None:
                self._drift.follow(estimate, validity, envelope.stamp)
            if self._taring.active and validity.complete and frame.imu_valid[0]:
                self._taring.add(frame, envelope.stamp)
            if not 0 <= envelope.stamp - self._uncertain_since < self._uncertainty_age:
                motion = frame.q, frame.dq, frame.ddq, *self._inertial
                self._refresh_uncertainty(motion, envelope.stamp)
        self._node.acknowledge(envelope.stamp)

    def _step(self, frame: SensorFrame) -> tuple[Estimate, np.ndarray]:
        """Return the estimate, and whether there was a kinematic source, (1 or more,)."""
        valid = frame.imu_valid
        self._inertial = frame.imu_gyro[0], frame.imu_acc[0], frame.imu_dgyro[0]
        if self._source is not None:
            source = self._source.step(frame)
            self._inertial, valid = source.motion, np.array([source.valid])
        self._sample = frame.q, frame.dq, frame.ddq, frame.ft, *self._inertial
        return self._observer.step(*self._sample), valid

    def _make_source(self, config: TorqueObserverConfig) -> KinematicSource | None:
        """None where the first inertial sensor, the observer's root, is the source itself."""
        name, robot = config.kinematic_source, self._robot
        if name in (FIRST, robot.imus[0]):
            return None
        noise = InertialNoise(**config.source_noise.model_dump())
        return KinematicSource(robot, name, config.fixed_link_gravity, noise)

    def _write(self, estimate: Estimate, validity: Validity, like: Envelope) -> None:
        """Write torques, and what costs more only where somebody listens."""
        torques = self._composer.torques(estimate, self._uncertainty, validity)
        if validity.complete:
            self._torques.write(torques, like=like)
        else:
            self._judge(self._torques, torques, validity.torque, validity, like)
        if self._wrenches.wanted(like.stamp):
            wrenches = self._composer.wrenches(estimate, self._uncertainty, validity)
            self._judge(self._wrenches, wrenches, validity.subtree, validity, like)
        if self._predictions.wanted(like.stamp):
            prediction = self._composer.prediction(estimate, validity)
            self._judge(self._predictions, prediction, validity.prediction, validity, like)

    @staticmethod
    def _judge(output: Any, data: Any, valid: np.ndarray, validity: Validity, like: Any) -> None:
        """A message with at least one valid entry is valid; its flags tell which."""
        whole = validity.complete or bool(valid.any())
        output.write(data, like=like, valid=whole, reason="" if whole else validity.reason)

    def _complain(self) -> None:
        now = time.monotonic()
        if now - self._complained >= COMPLAINT:
            self._complained = now
            self._write_nothing(self._sensors.reason)

    def _write_nothing(self, reason: str) -> None:
        robot = self._robot
        torque, subtree, prediction = (
            np.zeros(size, dtype=bool)
            for size in (robot.n, len(robot.subtrees), len(robot.ft_sensors))
        )
        lost = Validity(torque, subtree, prediction, False, reason)
        for output, data in (
            (self._torques, self._composer.torques(self._nothing, self._uncertainty, lost)),
            (self._wrenches, self._composer.wrenches(self._nothing, self._uncertainty, lost)),
            (self._predictions, self._composer.prediction(self._nothing, lost)),
        ):
            output.write(data, like=self._last, valid=False, reason=reason)

    def _touch(self, points: ContactPoints) -> None:
        """Move the contacts; points that cannot be told apart leave them as they are."""
        try:
            self._observer.set_contacts(touches(points))
        except (LookupError, ValueError) as error:
            self._touch_error = str(error)
            logger.warning("%s: %s", self._points.name, error)
        else:
            self._touch_error = ""
            self._follow_contacts()

    def _follow_contacts(self) -> None:
        """Bring up to date what depends on where the contacts are."""
        self._composer.prepare()
        self._dependencies = ChannelDependencies(self._observer.graph, self._source_name)
        self._uncertainty_age = int(self._config.uncertainty_period * 1e9)
        q, dq, ddq, _, *inertial = _still(self._robot)
        self._refresh_uncertainty((q, dq, ddq, *inertial), -self._uncertainty_age)

    def _refresh_uncertainty(self, motion: tuple[np.ndarray, ...], stamp: int) -> None:
        noise = ObserverNoise(**self._config.noise.model_dump())
        covariance = None
        if self._source is not None:
            self._source.refresh(motion[0])
            covariance = self._source.covariance
        self._uncertainty = propagate(self._observer, noise, *motion, source=covariance)
        self._uncertain_since = stamp

    def _configure(self, old: TorqueObserverConfig, new: TorqueObserverConfig) -> None:
        if old.drift.follow != new.drift.follow:
            raise ValueError("drift.follow cannot be changed while the service runs")
        fixed = ("robot", "lockstep", "follow_touches", "inputs")
        if changed := [name for name in fixed if getattr(old, name) != getattr(new, name)]:
            raise ValueError(f"{changed[0]} cannot be changed while the service runs")
        source = self._make_source(new)
        self._config, self._source = new, source
        self._tares.configure(new.tare)
        if new.support != old.support:
            self._taring.abandon(f"the support is now '{new.support}'")
            self._observer.set_contacts(support=new.support)
        if self._drift is not None:
            self._drift.configure(new.drift)
        self._follow_contacts()

    @property
    def _source_name(self) -> str:
        return self._robot.imus[0] if self._source is None else self._source.name

    def wrench(
        self, of: str, frame: str = "", axes: str = "", point: list[float] | None = None
    ) -> dict[str, Any]:
        """Return a wrench of the last sample; see `WrenchQuery`."""
        if self._sample is None or self._last is None:
            raise ValueError("no valid sensor frame yet")
        told, where = WrenchQuery(self._observer, *self._sample).wrench(of, frame, axes, point)
        return {
            "of": of,
            "frame": where,
            "axes": axes or where,
            "point": point or [0.0, 0.0, 0.0],
            "force": told[:3].tolist(),
            "moment": told[3:].tolist(),
            "stamp": self._last.stamp,
            "valid": self._validity.complete and self._last.valid,
            "reason": self._last.reason or self._validity.reason,
        }

    def status(self) -> dict[str, Any]:
        """Return the state of the service and what it assumes."""
        names = self._robot.ft_sensors
        contacts = [[c.frame, c.kind, *c.point.tolist()] for c in self._observer.contacts]
        return {
            **self._node.status(),
            "support": self._observer.support,
            "kinematic_source": self._source_name,
            "contacts": contacts,
            "contact_error": self._touch_error,
            "offset": dict(zip(names, self._observer.offset.tolist(), strict=True)),
            "tare": self._tares.status(),
            "drift": self._drift.status() if self._drift else {"followed": []},
            "taring": self._taring.active,
        }


def _still(robot: Robot) -> tuple[np.ndarray, ...]:
    """Arguments of an observer step at home posture, whose results are never shown."""
    n, k = robot.n, len(robot.ft_sensors)
    return robot.home, np.zeros(n), np.zeros(n), np.zeros((k, 6)), *np.zeros((3, 3))
