"""The line of a contact force and its candidates (R eq. 22, Figure 9), with exact residuals.

The force and the moment of the external residual give a line. Where it enters the surface
are the candidates; the joints' torques, the internal residual, choose among them.
"""

from typing import NamedTuple

import numpy as np

from experiments.residual_run import Push, ResidualTruth
from experiments.touch.pushes import PushGenerator, TouchPush
from robot_model import Robot

Array = np.ndarray
MISS = 0.006  # m from the line at which a stored point, 10 mm from the next, is a cut
ENTERS = 0.2  # least cosine between the force and the inward normal
ENTRY = 0.03  # m between cuts of one body that are different entries
ALIKE = 0.1  # N m, difference of torques that noise would hide


class Candidate(NamedTuple):
    """A body that the line enters."""

    link: str
    points: Array  # (entries, 3) m on the line, in base axes
    misfit: float  # N m, largest difference of a joint's torque


class CandidateFinder:
    """Finds the candidates of pushes on a robot in its home posture."""

    def __init__(self, robot: Robot):
        self._robot, self._truth = robot, ResidualTruth(robot)
        surface = robot.load_surface()
        placements = self._truth.placements(robot.home)
        places = [placements[body.name] for body in surface.bodies]
        rotations = np.array([place.rotation for place in places])[surface.body]
        origins = np.array([place.translation for place in places])[surface.body]
        self.placements = placements
        self._points = np.einsum("pij,pj->pi", rotations, surface.points) + origins
        self._normals = np.einsum("pij,pj->pi", rotations, surface.normals)
        self._links = np.array([body.name for body in surface.bodies])[surface.body]

    def find(self, push: TouchPush) -> list[Candidate]:
        """Return the candidates of a push, likeliest first."""
        place = self.placements[push.link]
        force, point = place.rotation @ push.force, place.act(push.point)
        real = self.torque(push.link, push.point, force)
        start = np.cross(force, np.cross(point, force)) / (force @ force)  # eq. (22)
        direction = force / np.linalg.norm(force)
        distance = np.linalg.norm(np.cross(self._points - start, direction), axis=1)
        near = np.flatnonzero((distance < MISS) & (self._normals @ direction < -ENTERS))
        found = []
        for link in dict.fromkeys(self._links[near].tolist()):
            mine = near[self._links[near] == link]
            entries = _entries(self._points[mine], start, direction)
            here = self.placements[link].actInv(entries[0])
            misfit = np.abs(self.torque(link, here, force) - real).max()
            found.append(Candidate(link, entries, float(misfit)))
        return sorted(found, key=lambda candidate: candidate.misfit)

    def torque(self, link: str, point: Array, force: Array) -> Array:
        """J_fb^T f, (n,), of a force in base axes at a point of a link."""
        _, internal = self._truth.maps(self._robot.home, [Push(link, point, force)])
        return internal @ force


def _entries(points: Array, start: Array, direction: Array) -> Array:
    """Where on the line each group of points begins, first come first, (entries, 3)."""
    along = np.sort((points - start) @ direction)
    first = along[np.concatenate(([True], np.diff(along) > ENTRY))]
    return start + first[:, None] * direction


class Summary(NamedTuple):
    """What the candidates of many pushes come to."""

    pushes: int
    bodies: float  # that a line enters, mean
    entries: float  # likewise, of all bodies
    cut: float  # share of lines that enter the pushed body at a stored point
    first: float  # share of these of which the torques name the pushed body alone or first
    undecided: float  # share of these with another body within ALIKE


def summary(robot: Robot, seed: int, count: int) -> tuple[Summary, list[tuple]]:
    """Return the summary of random pushes, and the candidates of the one with most of them."""
    finder, generator = CandidateFinder(robot), PushGenerator(robot)
    found, most = [], (0, [])
    for index in range(count):
        random = np.random.default_rng([seed, index])
        push = generator.draw(random, int(random.choice(generator.subtrees("free"))), "free")
        candidates = finder.find(push)
        found.append((push, candidates))
        if len(candidates) > most[0] and any(c.link == push.link for c in candidates):
            most = len(candidates), _example(finder, push, candidates)
    cut = [(p, cs) for p, cs in found if any(c.link == p.link for c in cs)]
    alike = [sum(c.misfit < ALIKE for c in cs) > 1 for _, cs in cut]
    return Summary(
        pushes=count,
        bodies=float(np.mean([len(cs) for _, cs in found])),
        entries=float(np.mean([sum(len(c.points) for c in cs) for _, cs in found])),
        cut=len(cut) / count,
        first=float(np.mean([cs[0].link == p.link for p, cs in cut])),
        undecided=float(np.mean(alike)),
    ), most[1]


def _example(finder: CandidateFinder, push: TouchPush, candidates: list[Candidate]) -> list[tuple]:
    true = finder.placements[push.link].act(push.point)
    rows = []
    for candidate in candidates:
        away = float(np.linalg.norm(candidate.points - true, axis=1).min())
        name = f"{candidate.link} (pushed)" if candidate.link == push.link else candidate.link
        rows.append((name, len(candidate.points), 1e3 * away, candidate.misfit))
    return rows
