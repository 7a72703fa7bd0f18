"""What belongs to a recording besides messages: settings of all services, the robot's files."""

import hashlib
import json
import logging
from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor, wait
from typing import Any, NamedTuple

from bus import BusError, Node
from bus.recording import RecordingWriter
from bus.tokens import Owner
from robot_model import DescriptionError
from robot_model.description import description_file, find_urdf, read_description

logger = logging.getLogger(__name__)

ANSWER = 1.0  # s for a service to tell its settings


class RobotFiles(NamedTuple):
    """A robot's name, the hash of its joints, its description and its URDF."""

    name: str
    model: str
    description: bytes
    urdf: bytes


class Circumstances:
    """Asks every service once, in a thread; what has been told goes into the recording."""

    def __init__(self, node: Node, writer: RecordingWriter):
        self._node, self._writer = node, writer
        self._worker = ThreadPoolExecutor(1, thread_name_prefix="circumstances")
        self._known: set[Owner] = set()
        self._robots: set[str] = set()
        self._open: list[tuple[Future[Any], Callable[[Any], None]]] = []

    def step(self) -> None:
        """Ask services that have appeared, and attach what was answered."""
        for owner in self._node.directory.services():
            if owner in self._known:
                continue
            self._known.add(owner)
            if owner.node == self._node.owner.node:  # it would have to answer itself
                self._attach_settings(owner.service, self._node.parameters.handle("list"))
            else:
                self._send(self._ask, owner.service, lambda told: self._attach_settings(*told))
        ended = [entry for entry in self._open if entry[0].done()]
        self._open = [entry for entry in self._open if not entry[0].done()]
        for future, then in ended:
            then(future.result())

    def close(self, patience: float = 2 * ANSWER) -> None:
        """Attach what is still on the way, and ask no more."""
        for _ in range(2):  # settings, then the robot that they name
            self.step()
            wait([future for future, _ in self._open], patience / 2)
        self.step()
        self.abandon()

    def abandon(self) -> None:
        """Ask no more."""
        self._worker.shutdown(wait=False, cancel_futures=True)

    def _send(self, work: Callable[[str], Any], name: str, then: Callable[[Any], None]) -> None:
        self._open.append((self._worker.submit(work, name), then))

    def _ask(self, service: str) -> tuple[str, dict[str, Any]]:
        request = {"action": "list"}
        try:
            return service, self._node.call(f"/{service}/rpc:i", "param", request, timeout=ANSWER)
        except BusError as error:
            logger.warning("the settings of %s are not in the recording: %s", service, error)
            return service, {}

    def _attach_settings(self, service: str, settings: dict[str, Any]) -> None:
        if not settings:
            return
        content = json.dumps(settings, indent=1).encode()
        self._writer.attach(f"config/{service}.json", "application/json", content)
        robot = settings.get("robot")
        if isinstance(robot, str) and robot not in self._robots:
            self._robots.add(robot)
            self._send(_read_robot, robot, self._attach_robot)

    def _attach_robot(self, robot: RobotFiles | None) -> None:
        if robot is None:
            return
        self._writer.attach(f"robot/{robot.name}.yaml", "application/yaml", robot.description)
        self._writer.attach(f"robot/{robot.name}.urdf", "application/xml", robot.urdf)
        self._writer.note("robot", {"name": robot.name, "model": robot.model})


def _read_robot(robot: str) -> RobotFiles | None:
    try:
        file = description_file(robot)
        description = read_description(file)
        urdf, _ = find_urdf(description.urdf, file)
        joints = "\n".join(row.name for row in description.joints)
        model = hashlib.sha256(joints.encode()).hexdigest()[:8]
        return RobotFiles(description.name, model, file.read_bytes(), urdf.read_bytes())
    except (DescriptionError, OSError) as error:
        logger.warning("robot %s is not in the recording: %s", robot, error)
        return None
