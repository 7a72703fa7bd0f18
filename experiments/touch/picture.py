"""A picture of one run: where the robot was pushed, where the detector says, what limbs felt."""

from collections.abc import Iterator
from dataclasses import asdict
from typing import TYPE_CHECKING, NamedTuple

import numpy as np
import pinocchio as pin

from estimation.contact.localisation import NOWHERE, Localisation
from estimation.contact.touch_map import NO_MAP, TouchMap
from experiments.report import Report
from experiments.svg import svg
from experiments.touch.cases import Case, pushed_case
from experiments.touch.conditions import VARIANTS, Condition
from experiments.touch.pushes import PushGenerator
from experiments.touch.scores import Course, TouchScore, judged, pushed
from experiments.touch.watched_robot import Sight, WatchedRobot
from robot_model import Robot

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = np.ndarray
MARGIN = 0.15  # m around the places of interest
ARROW = 0.004  # m per N
BEFORE = 1.0  # s before the push that are shown
VIEWS = (("looking along -x", 1, "y"), ("looking along +y", 0, "x"))  # horizontal axis of the base
TRUE, GUESS, BODY = "#1f77b4", "#d6249f", "#c8ccd2"


class Looked(NamedTuple):
    """What there was to see at one localisation."""

    located: Localisation
    places: TouchMap
    placements: dict[str, pin.SE3]  # of links, in the frame of the base


class Remembering(WatchedRobot):
    """Keeps what the picture shows."""

    def __init__(self, robot: Robot, case: Case, condition: Condition):
        self.statistics: list[tuple[int, list[float]]] = []  # stamp, share of each threshold
        self.looks: list[Looked] = []
        super().__init__(robot, case, condition)

    def _look(self, locate: bool) -> Sight:
        sight = super()._look(locate)
        judged = [f.statistic / f.threshold if f.threshold else np.nan for f in self.flags]
        self.statistics.append((sight.stamp, judged))
        return sight

    def _locate(self) -> Localisation:
        located = super()._locate()
        self.looks.append(Looked(located, self.detector.locator.map(), self._placements()))
        return located

    def _placements(self) -> dict[str, pin.SE3]:
        robot, placed = self.robot, self.detector.rows.place_links()
        base = placed[robot.links.index(robot.base_link)].inverse()
        return {link: base * place for link, place in zip(robot.links, placed, strict=True)}

    def look_at(self, course: Course) -> Looked:
        """Return what there was to see when the push was judged, else what there is now."""
        for look in self.looks:
            if course.moment is not None and look.located is course.moment.located:
                return look
        return Looked(NOWHERE, NO_MAP, self._placements())


def draw(robot: Robot, seed: int, index: int, condition: Condition) -> Report:
    """Repeat the push of a seed and an index, and return its score and its picture."""
    contacts = VARIANTS[condition.variant].contacts
    case = pushed_case(PushGenerator(robot), robot, seed, index, contacts)
    watched = Remembering(robot, case, condition)
    course = pushed(watched, case)
    score = judged(robot, watched, case, course)
    name = "_".join(("touch", str(seed), str(index), *condition[1:]))
    picture = svg(lambda: _figure(robot, watched, case, course, score, condition))
    lines = [f"{key}: {value}" for key, value in asdict(score).items()]
    return Report(name, asdict(score), lines, {f"{name}.svg": picture})


def _figure(
    robot: Robot,
    watched: Remembering,
    case: Case,
    course: Course,
    score: TouchScore,
    condition: Condition,
) -> "Figure":
    from matplotlib.figure import Figure

    look = watched.look_at(course)
    figure = Figure(figsize=(9.0, 7.2), layout="constrained")
    figure.suptitle(_title(case, score, condition), fontsize=9)
    parts = figure.subplot_mosaic([["y", "x"], ["time", "time"]], height_ratios=(2.2, 1.0))
    for name, axis, label in VIEWS:
        _draw_view(parts[label], robot, look, case, axis)
        parts[label].set(title=name, xlabel=f"{label} [m], axes of the base", ylabel="z [m]")
    _draw_statistics(parts["time"], watched, case, course)
    figure.legend(fontsize=7, ncols=7, loc="outside lower center")
    return figure


def _title(case: Case, score: TouchScore, condition: Condition) -> str:
    forces = zip(score.links, score.forces, strict=True)
    truth = ", ".join(f"{link} {force:.0f} N ({score.kind})" for link, force in forces)
    ranked = zip(score.ranking[:3], score.probabilities, strict=False)
    told = ", ".join(f"{link} {p:.2f}" for link, p in ranked) or "nothing"
    return (
        f"seed {case.seed}, run {case.index}: {condition.profile}, {condition.variant}, "
        f"{case.kind}\npushed (blue): {truth}\n"
        f"told (pink): {told}; none of these {score.none_probability:.2f}"
    )


def _draw_view(axes: "Axes", robot: Robot, look: Looked, case: Case, axis: int) -> None:
    seen = [axis, 2]
    surface = robot.load_surface()
    owner = [surface.bodies[i].name for i in surface.body.tolist()]
    body = _placed(owner, surface.points, look.placements)[:, seen]
    axes.scatter(*body.T, s=2.0, c=BODY, linewidths=0, rasterized=True)
    _draw_places(axes, look, seen)
    tips = []
    for colour, link, point, force in _arrows(look, case):
        tip = look.placements[link].act(point)
        tail = tip - ARROW * look.placements[link].rotation @ force
        width = 2.5 if colour == TRUE else 1.0
        arrow = {"color": colour, "arrowstyle": "-|>", "shrinkA": 0, "shrinkB": 0, "lw": width}
        axes.annotate("", tip[seen], tail[seen], arrowprops=arrow)
        tips += [tip[seen], tail[seen]]
    low, high = np.min(tips, axis=0), np.max(tips, axis=0)
    middle, half = (low + high) / 2, np.max(high - low) / 2 + MARGIN
    axes.set(xlim=middle[0] + [-half, half], ylim=middle[1] + [-half, half], aspect="equal")


def _draw_places(axes: "Axes", look: Looked, seen: list[int]) -> None:
    """Colour the places that are not out of the question by the logarithm of their probability."""
    places = look.places
    links = np.repeat(np.array(places.link, dtype=object), places.count)
    placed = _placed(links.tolist(), places.point, look.placements)[:, seen]
    share = np.log10(places.probability / places.probability.max(initial=1e-300) + 1e-9)
    shown = np.argsort(share)
    shown = shown[share[shown] > -2.0]
    axes.scatter(*placed[shown].T, s=9.0, c=share[shown], vmin=-2.0, vmax=0.0, cmap="YlOrRd", lw=0)


def _arrows(look: Looked, case: Case) -> Iterator[tuple[str, str, Array, Array]]:
    """Colour, link, point [m] and force [N] of the pushes and of the best guess on each limb."""
    for push in case.pushes:
        yield TRUE, push.link, push.point, push.force
    for guess in look.located.hypotheses[: len(case.pushes)]:
        yield GUESS, guess.links[0], guess.point, guess.force


def _placed(links: list[str], points: Array, placements: dict[str, pin.SE3]) -> Array:
    """Turn points (p, 3), each in the frame of its link, to the base's axes."""
    names = np.array(links, dtype=object)
    placed = np.empty((len(points), 3))
    for link in set(links):
        mine = names == link
        place = placements[link]
        placed[mine] = points[mine] @ place.rotation.T + place.translation
    return placed


def _draw_statistics(axes: "Axes", watched: Remembering, case: Case, course: Course) -> None:
    stamps = (np.array([stamp for stamp, _ in watched.statistics]) - course.start) * 1e-9
    shares = np.array([share for _, share in watched.statistics])
    shown = stamps > -BEFORE
    for limb, share in zip(watched.detector.monitor.limbs, shares.T, strict=True):
        if not np.isnan(share[shown]).all():
            axes.plot(stamps[shown], share[shown], lw=0.8, label=limb)
    axes.axhline(1.0, color="black", lw=0.6, ls="--")
    axes.axvspan(0.0, case.pushes[0].length, color=TRUE, alpha=0.12, lw=0)
    axes.set(
        yscale="log",
        ylim=(0.02, None),
        xlabel="time from the push [s]",
        ylabel="statistic / threshold",
    )
