"""The robot and what pushes it, from the newest messages."""

import numpy as np
import viser

from robot_model import Robot
from robot_model.messages import ContactMap, Contacts, ExternalWrenches, GroundTruth
from robot_model.surface import Surface

from .config import DashboardConfig
from .force_scene import ForceScene
from .forces import Force, estimated_forces, segments, true_forces
from .likelihood import Likelihood
from .placement import Placement
from .robot_scene import RobotScene
from .snapshot import Snapshot
from .touches import action_lines, raised, touches

Array = np.ndarray

NOTHING = np.zeros((0, 2, 3), dtype=np.float32)


class View:
    """The three-dimensional part of the page. ``estimate`` never sees the truth."""

    def __init__(
        self, scene: viser.SceneApi, robot: Robot, surface: Surface, config: DashboardConfig
    ):
        self.estimate = Placement(robot)
        self._truth = Placement(robot)
        links = tuple(body.name for body in surface.bodies)
        self._robot = RobotScene(scene, surface, self.estimate.parents(links))
        self._likelihood = Likelihood(scene, self._robot.paths, surface, config.map_rate)
        self._forces = ForceScene(scene)
        self._config = config
        self._base = robot.base_link
        self._seen = False

    def update(self, now: Snapshot, show_truth: bool, hide_below: float) -> None:
        """Draw what is known; what is not disappears, and a robot that is not seen turns grey."""
        if now.sensors is None or now.base is None:
            now = Snapshot(truth=now.truth)
        else:
            self.estimate.update(now.sensors.q, now.base.position, now.base.quat_wxyz)
            self._robot.place(self.estimate.poses(self._robot.links, self._robot.parents))
            self._seen = True
        places = now.contact_map if now.contacts is not None and raised(now.contacts) else None
        self._draw_contacts(now.contacts, stale=now.sensors is None, dots=places is None)
        self._draw_places(places)
        self._draw_estimate(now.wrenches, hide_below)
        self._draw_truth(now.truth if show_truth else None, hide_below)

    def camera(self) -> tuple[Array, Array] | None:
        """Return where to stand and where to look, world; None before the robot was seen."""
        if not self._seen:
            return None
        offsets = (self._config.camera_offset, self._config.camera_look_at)
        position, look_at = (self.estimate.point(self._base, np.array(o)) for o in offsets)
        return position, look_at

    def _draw_contacts(self, contacts: Contacts | None, stale: bool, dots: bool) -> None:
        """Dots stand for a map of the surface where there is none."""
        found = [] if contacts is None else touches(contacts, self.estimate)
        self._forces.show_hypotheses(found, self._config.touch_scale, dots)
        touched = np.array(
            [sum(t.probability for t in found if t.link == link) for link in self._robot.links]
        )
        self._robot.shade(touched, stale)

    def _draw_places(self, found: ContactMap | None) -> None:
        """Draw the map of a touch, and its line of action."""
        self._likelihood.show(found)
        lines = [] if found is None else action_lines(found, self._base, self.estimate)
        self._forces.show_lines(np.array(lines, dtype=np.float32).reshape(-1, 2, 3))

    def _draw_estimate(self, wrenches: ExternalWrenches | None, hide_below: float) -> None:
        forces = [] if wrenches is None else estimated_forces(wrenches, self.estimate)
        undecided = [force for force in forces if not force.decided]
        decided = [force for force in forces if force.decided]
        unsure = np.concatenate(self._arrows(undecided, hide_below))
        self._forces.show_estimate(*self._arrows(decided, hide_below), unsure)

    def _draw_truth(self, truth: GroundTruth | None, hide_below: float) -> None:
        if truth is None:
            self._forces.show_truth(NOTHING)
            return
        self._truth.update(truth.q, truth.base_position, truth.base_quat_wxyz)
        arrows = self._arrows(true_forces(truth, self._truth), hide_below)
        self._forces.show_truth(np.concatenate(arrows))

    def _arrows(self, forces: list[Force], hide_below: float) -> tuple[Array, Array]:
        touches = (force for force in forces if not force.support)
        supports = (force for force in forces if force.support)
        return (
            segments(touches, self._config.touch_scale, hide_below),
            segments(supports, self._config.support_scale, hide_below),
        )
