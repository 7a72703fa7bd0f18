"""The contact detector: sensor frames in, residuals and contacts out."""

from functools import partial
from typing import Any

import numpy as np

from bus import Node, Pending, Received
from bus.envelope import Envelope
from bus.lockstep import Join
from bus.paced import WAIT, Complaint
from bus.rhythm import Rhythm
from estimation.contact.contact_detector import ContactDetector
from estimation.contact.limb_monitor import LimbFlag
from estimation.contact.touch_locator import Look, TouchLocator
from estimation.contact.touch_map import NO_MAP
from estimation.offline.log_attitude import upward
from estimation.residual.residual_bank import ResidualBank
from robot_model import Robot, load_robot, ports
from robot_model.messages import BaseState, SensorFrame
from services.contact_detector.calibrations import Calibrations
from services.contact_detector.config import ContactDetectorConfig
from services.contact_detector.outputs import Outputs
from services.contact_detector.place_search import Found, PlaceSearch
from services.contact_detector.taring import Taring

UNREAD = 20_000_000  # ns between residuals that nobody reads, so that they are there at once


def main(node: Node, config: ContactDetectorConfig) -> None:
    """Watch one robot until asked to stop."""
    service = ContactService(node, load_robot(config.robot), config)
    node.ready()
    while node.running:
        service.spin()


class ContactService:
    """Moves sensor frames to the mathematics, and what it finds to the ports."""

    def __init__(self, node: Node, robot: Robot, config: ContactDetectorConfig):
        self._node, self._robot, self._config = node, robot, config
        self._open_ports()
        self.rebuild()
        self._stamp: int | None = None
        self._next = self._next_location = self._evaluated = 0  # stamps, ns
        self._rhythm, self._found = Rhythm(1.0 / config.rate), False
        self._complaint = Complaint(self._complain)
        self._up_base: np.ndarray | None = None
        self._flags: list[LimbFlag] = []
        self._search = PlaceSearch(beside=not config.lockstep)
        node.verb("tare", self._tare, help="take what the resting robot shows for zero {seconds}")
        node.verb("calibrate", self._calibrate, help="learn from a motion untouched {seconds}")
        node.verb("calibrations", self._listed, help="list stored calibrations")
        node.verb("use_calibration", self._use, help="put a stored one in force; none {date}")
        node.verb("forget_calibration", self._forget, help="remove a stored one {date}")
        node.verb("status", self.status, help="state, tare, thresholds per limb")
        node.parameters.on_change(self._configure)

    def _open_ports(self) -> None:
        node, robot = self._node, self._robot
        common: dict[str, Any] = {"model": robot.model_hash, "dimensions": robot.dimensions}
        self._sensors = node.input(
            ports.service_input(robot, node.name, "sensors"),
            SensorFrame,
            source=self._source("sensors"),
            depth=64,
            rate=ports.rate("sensors"),
            polled=not self._config.lockstep,
            stream="whole" if self._config.lockstep else "bundled",
            **common,
        )
        self._base = node.input(
            ports.service_input(robot, node.name, "base"),
            BaseState,
            source=self._source("base"),
            rate=ports.rate("base"),
            polled=not self._config.lockstep,
        )
        self._join = Join(node, [self._base])
        self._outputs = Outputs(node, robot, self._config)

    def _source(self, key: str) -> str:
        return self._config.inputs.get(key, ports.name(key, self._robot))

    def rebuild(self) -> None:
        """Make the mathematics anew, as after a change of the support."""
        config, robot = self._config, self._robot
        self.detector = ContactDetector(robot, config.support, config.detector_settings())
        self._bank = ResidualBank(robot, config.support, config.residual_settings())
        self._taring = Taring(self.detector, self._bank, config.tare)
        kept = config.calibration
        if config.lockstep:  # whose runs must repeat, whatever is stored
            kept = kept.model_copy(update={"load": False})
        self._calibrations = Calibrations(self.detector, config.support, kept)

    def spin(self) -> None:
        """Wait for frames and work off all that came."""
        self._node.wait(WAIT if self._config.lockstep else self._rhythm.rest(self._found))
        self._base.newest()  # in every support, so that its statistics count
        self._up_base = self._look_up()
        self._found = False
        while (received := self._sensors.read()) is not None:
            self._found = True
            self._take(received)
            if self._config.lockstep:
                self._node.acknowledge(received.envelope.stamp)
        if not self._sensors.fresh:
            self._complaint.make(self._sensors.reason)

    @property
    def latest(self) -> Received | None:
        """The last sensor frame that was taken."""
        return self._sensors.latest

    @property
    def busy(self) -> bool:
        """Whether a tare or calibration is under way."""
        return self._taring.busy

    def _take(self, received: Received) -> None:
        frame, envelope = received.data, received.envelope
        if not envelope.valid:
            self._complaint.make(envelope.reason or "the sensor frame is invalid")
            return
        stamp = envelope.stamp
        if self._config.lockstep and self._config.support != "floor":
            self._join.wait(stamp)
            self._up_base = self._look_up()
        if self._stamp is None or stamp <= self._stamp:
            self._restart()
        self._stamp = stamp
        due = stamp >= self._next
        self._bank.step(frame, stamp, self._up_base, due and self._is_residual_due(stamp))
        if due:
            period = round(1e9 / self._config.rate)
            self._next = max(self._next + period, stamp + period // 2)
            self._detect(frame, stamp)
            self._publish(envelope)

    def _is_residual_due(self, stamp: int) -> bool:
        """Forces are integrated at every sample, momenta are computed where somebody looks."""
        read = self.busy or self._outputs.wants_residuals(stamp)
        if not read and 0 <= stamp - self._evaluated < UNREAD:
            return False
        self._evaluated = stamp
        return True

    def _restart(self) -> None:
        """The stamps jumped back: what was remembered belongs to another run."""
        self.detector.reset()
        self._bank.reset()
        self._next = self._next_location = 0
        self._outputs.restart()
        self._search.forget()

    def _look_up(self) -> np.ndarray | None:
        """Upwards in base axes by the base estimator, None when that is not known or needed."""
        latest = self._base.latest
        if self._config.support == "floor":
            return None
        if latest is None or not self._base.fresh or not latest.envelope.valid:
            return None
        return upward(latest.data.quat_wxyz)

    def _detect(self, frame: SensorFrame, stamp: int) -> None:
        self._flags = self.detector.step(frame, stamp)
        self._taring.add(frame, stamp)
        idle = self._search.idle
        if not self.detector.touched or not self.detector.tared:
            self._search.forget()
            self._next_location = 0
        elif idle and stamp >= self._next_location:
            mapped, look = self._outputs.wants_map(stamp), self.detector.look(frame)
            self._search.begin(partial(_find, self.detector.locator, look, mapped))
            self._next_location = stamp + round(1e9 / self._config.locate_rate)

    def _publish(self, like: Envelope) -> None:
        doubt, config, outputs = self._doubt(), self._config, self._outputs
        outputs.residuals(self._bank, like)
        found = self._search.found
        outputs.contacts(self.detector, self._flags, found, like, doubt)
        if config.tell_points:
            period = round(1e9 / config.locate_rate)
            outputs.places(self.detector.touched, found.located, period, like, doubt)

    def _doubt(self) -> str:
        """Why nothing is said about contacts."""
        if not self.detector.tared:
            return self._taring.waits
        judged = [flag for flag in self._flags if flag.valid]
        return "" if judged else next((flag.reason for flag in self._flags), "no sample")

    def _complain(self, reason: str) -> None:
        """Say that nothing is known, with the last stamp."""
        latest, tells = self._sensors.latest, self._config.tell_points
        like = latest.envelope if latest is not None else None
        self._outputs.complain(self.detector, self._bank, tells, like, reason)

    def _tare(self, seconds: float = 1.0) -> Pending:
        return self._taring.request(seconds, self._taring.tare)

    def _calibrate(self, seconds: float = 30.0) -> Pending:
        """Learn floors and thresholds from a robot that moves and that nothing touches."""
        if not self.detector.tared:
            raise RuntimeError(f"the contact detector is not tared: {self._taring.waits}")
        largest = self._config.tare.largest_bias
        return self._taring.request(seconds, self._calibrations.finish, largest)

    def _listed(self) -> dict[str, Any]:
        return self._calibrations.listed()

    def _use(self, date: str) -> dict[str, Any]:
        return self._calibrations.use(date)

    def _forget(self, date: str) -> dict[str, Any]:
        return self._calibrations.forget(date)

    def _configure(self, old: ContactDetectorConfig, new: ContactDetectorConfig) -> None:
        if new.support not in self._robot.supports:
            known = ", ".join(self._robot.supports)
            raise ValueError(f"{self._robot.name} has no support '{new.support}'; it has: {known}")
        old.check_change(new)
        if new.support != old.support or new.noise != old.noise or new.tare != old.tare:
            self._config = new
            self.rebuild()
            self._restart()
        else:
            self._bank.configure(new.residual_settings())
            self.detector.configure(new.detector_settings())
            self._config = new

    def status(self) -> dict[str, Any]:
        """Return the state of service, tare and thresholds."""
        monitor = self.detector.monitor
        thresholds = dict(zip(monitor.limbs, monitor.threshold.tolist(), strict=True))
        return {
            **self._node.status(),
            "support": self._config.support,
            "tared": self.detector.tared,
            "thresholds": thresholds,
            "body_threshold": float(self.detector.body_monitor.threshold[0]),
            "calibration": self._calibrations.status(),
        }


def _find(locator: TouchLocator, look: Look, mapped: bool) -> Found:
    return Found(locator.search(look), locator.map() if mapped else NO_MAP)
