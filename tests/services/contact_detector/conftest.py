"""A contact detector in this process, and a recording of a pushed robot to feed it."""

from collections.abc import Callable, Iterator, Sequence
from concurrent.futures import Future, ThreadPoolExecutor
from dataclasses import dataclass
from typing import Any

import numpy as np
import pytest

from bus import Input, Node, Received
from bus.introspection import port_info
from bus.parameters import Parameters
from bus.testing import eventually, running_hub
from estimation.sensor_pipeline import SensorPipeline
from robot_model import Robot, load_robot, ports
from robot_model.messages import (
    BaseState,
    ContactMap,
    ContactPoints,
    Contacts,
    Residuals,
    SensorFrame,
)
from robot_sim import Plant
from services.contact_detector.config import ContactDetectorConfig
from services.contact_detector.service import ContactService

EVERY = 4  # ticks between recorded frames
Wanted = Callable[[Received], bool]
Frames = list[tuple[int, SensorFrame]]  # stamp [ns], frame


@dataclass(frozen=True, eq=False)
class Recording:
    """A robot that stands still, and then is pushed on the left forearm."""

    quiet: Frames
    pushed: Frames
    base: BaseState
    point: np.ndarray  # (3,) m, in the link's frame


@pytest.fixture(scope="session")
def robot() -> Robot:
    return load_robot("icub")


@pytest.fixture(scope="session")
def recording(robot: Robot) -> Recording:
    plant, pipeline = Plant(robot), SensorPipeline(robot)

    def record(ticks: int) -> Frames:
        frames = []
        for tick in range(ticks):
            plant.step()
            if tick % EVERY == EVERY - 1:
                frames.append((plant.time, pipeline.step(plant.raw(), plant.time)))
        return frames

    record(2000)
    quiet = record(1600)
    surface = robot.load_surface()
    forearm = [body.name for body in surface.bodies].index("l_forearm")
    mine = np.flatnonzero(surface.body == forearm)
    index = int(mine[len(mine) // 3])
    plant.push("l_forearm", surface.points[index], -15.0 * surface.normals[index])
    pushed = record(400)
    truth = plant.truth()
    base = BaseState(
        position=truth.base_position,
        quat_wxyz=truth.base_quat_wxyz,
        twist=truth.base_twist,
        covariance=np.zeros((12, 12)),
    )
    return Recording(quiet, pushed, base, surface.points[index])


class Bench:
    """The service, somebody who feeds it, and somebody who listens, in one thread."""

    def __init__(self, node: Node, user: Node, robot: Robot):
        self.node, self.robot = node, robot
        self.service = ContactService(node, robot, node.parameters.value)
        self._user = user
        self._pool = ThreadPoolExecutor(1)
        self._heard_contacts: list[Received] = []
        self._heard_residuals: list[Received] = []
        self._heard_maps: list[Received] = []
        types: dict[str, Any] = {"model": robot.model_hash, "dimensions": robot.dimensions}
        self._sensors = user.output(ports.name("sensors", robot), SensorFrame, **types)
        self._base = user.output(ports.name("base", robot), BaseState)
        self._contacts = self._listen(Contacts, ports.name("contacts", robot))
        self._residuals = self._listen(Residuals, ports.name("residuals", robot), **types)
        self._points = self._listen(ContactPoints, ports.name("touch_points", robot))
        self._heard_points: list[Received] = []
        node.ready()
        user.ready()
        eventually(lambda: self._sensors.matched and self._base.matched)
        eventually(lambda: node.directory.leader(self._sensors.name))
        eventually(lambda: node.directory.leader(self._base.name))
        eventually(lambda: user.directory.leader(ports.name("contacts", robot)))
        eventually(lambda: user.directory.leader(ports.name("residuals", robot)))
        eventually(lambda: all(self._is_heard(key, robot) for key in ("contacts", "residuals")))

    def _listen(self, kind: type, source: str, **types: Any) -> Input:
        return self._user.input(f"/user{source[:-1]}i", kind, source=source, depth=4096, **types)

    def _is_heard(self, key: str, robot: Robot) -> bool:
        return bool(port_info(self.node, ports.name(key, robot), 30.0)["wanted_hz"])

    def feed(self, frames: Frames, base: BaseState | None = None) -> None:
        """Let the service work off frames, a few at a time."""
        for stamp, frame in frames:
            if base is not None:
                self._base.write(base, stamp=stamp, clock=1)
            self._sensors.write(frame, stamp=stamp, clock=1)
            eventually(lambda stamp=stamp: self._has_taken(stamp))

    def _has_taken(self, stamp: int) -> bool:
        self.service.spin()
        latest = self.service.latest
        return latest is not None and latest.envelope.stamp == stamp

    def contacts(self, wanted: Wanted = lambda _: True) -> Received:
        """Return the newest contacts for which ``wanted`` holds."""
        return self._await(self._contacts, self._heard_contacts, wanted)

    def residuals(self, wanted: Wanted = lambda _: True) -> Received:
        """Return the newest residuals for which ``wanted`` holds."""
        return self._await(self._residuals, self._heard_residuals, wanted)

    def read_maps(self, robot: Robot) -> None:
        """Begin to listen to the map of the touches."""
        name = ports.name("contact_map", robot)
        self._maps = self._listen(ContactMap, name)
        eventually(lambda: self._user.directory.leader(name))
        eventually(lambda: self._is_heard("contact_map", robot))

    def maps(self, wanted: Wanted = lambda _: True) -> Received:
        """Return the newest map for which ``wanted`` holds."""
        return self._await(self._maps, self._heard_maps, wanted)

    def written(self, key: str, robot: Robot) -> int:
        """Return how many messages the service has written on a port."""
        return port_info(self.node, ports.name(key, robot), 30.0)["statistics"]["written"]

    def points(self, wanted: Wanted = lambda _: True) -> Received:
        """Return the newest places of touches for which ``wanted`` holds."""
        return self._await(self._points, self._heard_points, wanted)

    def heard_points(self) -> list[Received]:
        """Return all places that have been told so far."""
        while (received := self._points.read()) is not None:
            self._heard_points.insert(0, received)
        return self._heard_points

    def restarted(self) -> dict[str, Any]:
        """Let the service begin anew, as a new process would; return its status."""
        self.service.rebuild()
        return self.service.status()

    def _await(self, port: Input, heard: list[Received], wanted: Wanted) -> Received:
        """Messages of silence follow soon, so the wanted one need not be the last."""

        def look() -> Received | None:
            self.service.spin()
            while (received := port.read()) is not None:
                heard.insert(0, received)
            return next(filter(wanted, heard), None)

        found = eventually(look)
        assert found is not None
        return found

    def call(self, verb: str, arguments: dict[str, Any], frames: Frames) -> Any:
        """Ask the service while frames come in; return its answer or raise its error."""
        port = ports.rpc("contact_detector")
        answer: Future[Any] = self._pool.submit(self._user.call, port, verb, arguments, 20.0)
        eventually(lambda: self.service.spin() or self.service.busy or answer.done())
        self.feed(frames)
        eventually(lambda: self.service.spin() or answer.done())
        return answer.result()

    def close(self) -> None:
        self._pool.shutdown()


@pytest.fixture(scope="session")
def hub() -> Iterator[str]:
    with running_hub() as endpoint:
        yield endpoint


@pytest.fixture
def bench(hub: str, robot: Robot) -> Iterator[Bench]:
    settings = Parameters(ContactDetectorConfig())
    with (
        Node("contact_detector", connect=hub, signals=False, parameters=settings) as node,
        Node("user", connect=hub, signals=False) as user,
    ):
        opened = Bench(node, user, robot)
        yield opened
        opened.close()


def later(frames: Sequence[tuple[int, SensorFrame]], seconds: float) -> Frames:
    """Return the frames with other stamps."""
    return [(stamp + round(seconds * 1e9), frame) for stamp, frame in frames]
