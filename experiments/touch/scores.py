"""How one push was seen, and how a quarter of an hour without pushes was."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from estimation.contact.localisation import Hypothesis, Localisation
from experiments.touch.cases import Case
from experiments.touch.pushes import TouchPush
from experiments.touch.watched_robot import Sight, WatchedRobot
from robot_model import Robot

LINGER = 0.3  # s after the release in which a tap may still be seen
PAUSE = 0.5  # s without a flag, after which the next one is another alarm


@dataclass(frozen=True)
class TouchScore:
    """How a push, or two at once, was seen; links in the order of the pushes."""

    motion: str
    kind: str  # ramp, tap or press
    links: tuple[str, ...]  # truth
    subtrees: tuple[str, ...]
    forces: tuple[float, ...]  # N, largest
    fell: bool
    early: bool  # some limb was flagged before: a false alarm
    detected: bool  # some limb was flagged
    limb: bool  # of the first new flags one is right
    delay: float  # s from min(5 N, half the peak) to the first new flag; nan without one
    flagged: tuple[str, ...]  # limbs, in this order
    ranking: tuple[str, ...]  # links, best first
    probabilities: tuple[float, ...]
    none_probability: float
    first: bool  # with two pushes: both are the best of their limbs, or the first two
    among_three: bool
    point_error: float  # m, of the best hypothesis, the worse of two; nan without one
    force_error: float  # N, against the force at the instant that the sensors describe
    step_time: float  # s, median of detection
    locate_time: float  # s, median of localisation; nan without one


class ContactFreeScore(NamedTuple):
    """What the detector reported while nothing touched."""

    motion: str
    seconds: float
    alarms: int
    flagged_share: float  # of the time
    limbs: tuple[str, ...]  # that were flagged
    fell: bool
    step_time: float  # s


class Moment(NamedTuple):
    """A localisation and the instant that its sensors describe."""

    located: Localisation
    elapsed: float  # s since the push began


class Course(NamedTuple):
    """What was seen of a push."""

    before: list[Sight]
    seen: list[Sight]  # from its start on
    start: int  # stamp of its first tick, ns
    moment: Moment | None  # that is judged: the end of the hold, of a tap its largest force


def push_score(robot: Robot, watched: WatchedRobot, case: Case) -> TouchScore:
    """Let a robot move, push it, and return how that was seen."""
    return judged(robot, watched, case, pushed(watched, case))


def pushed(watched: WatchedRobot, case: Case) -> Course:
    """Let a robot move, push it, and return what was seen; a tap is over then."""
    before = watched.start_motion()
    start = watched.plant.time + 1_000_000  # a push acts from the next tick on
    for push in case.pushes:
        shape = {"duration": push.shape.duration, "rise": push.shape.rise}
        watched.plant.push(push.link, push.point, push.force, profile=push.shape.profile, **shape)
    seen = watched.watch(case.pushes[0].length, locate=True)
    held = None if case.pushes[0].kind == "tap" else watched.locate()
    if held is not None:
        elapsed = (watched.plant.time - start) * 1e-9 - watched.delay
        return Course(before, seen, start, Moment(held, elapsed))
    watched.plant.release()
    seen += watched.watch(LINGER, locate=True)
    return Course(before, seen, start, _best(seen, start, watched.delay))


def _best(seen: list[Sight], start: int, delay: float) -> Moment | None:
    """The localisation at the largest force."""
    located = [sight for sight in seen if sight.located is not None]
    if not located:
        return None
    best = max(located, key=lambda sight: sight.force)
    assert best.located is not None
    return Moment(best.located, (best.stamp - start) * 1e-9 - delay)


def judged(robot: Robot, watched: WatchedRobot, case: Case, course: Course) -> TouchScore:
    """Return how well a push was seen."""
    before, seen, start, moment = course
    pushes = case.pushes
    subtrees = tuple(robot.subtrees[robot.subtree_of(push.link)].name for push in pushes)
    flagged = tuple(dict.fromkeys(limb for sight in seen for limb in sight.touched))
    early = set(before[-1].touched) if before else set()
    first = next((sight for sight in seen if set(sight.touched) - early), None)
    noticeable = start * 1e-9 + pushes[0].noticeable
    hypotheses = moment.located.hypotheses if moment else ()
    chosen = [_hypothesis_for(robot, push, hypotheses, pushes) for push in pushes]
    errors = [_errors(watched, *pair, moment) for pair in zip(pushes, chosen, strict=True)]
    ranking = tuple(h.links[0] for h in hypotheses)
    return TouchScore(
        motion=case.kind,
        kind=pushes[0].kind,
        links=tuple(push.link for push in pushes),
        subtrees=subtrees,
        forces=tuple(push.size for push in pushes),
        fell=watched.plant.fallen,
        early=bool(early),
        detected=any(sight.touched for sight in seen),
        limb=first is not None and not set(subtrees).isdisjoint(set(first.touched) - early),
        delay=first.stamp * 1e-9 - noticeable if first else float("nan"),
        flagged=flagged,
        ranking=ranking,
        probabilities=tuple(h.probability for h in hypotheses),
        none_probability=moment.located.none_probability if moment else 1.0,
        first=all(h and h.links[0] == p.link for h, p in zip(chosen, pushes, strict=True)),
        among_three=all(push.link in ranking[: 2 + len(pushes)] for push in pushes),
        point_error=float(max(error[0] for error in errors)),
        force_error=float(max(error[1] for error in errors)),
        step_time=float(np.median(watched.step_times)),
        locate_time=float(np.median(watched.locate_times or [np.nan])),
    )


def _hypothesis_for(
    robot: Robot, push: TouchPush, hypotheses: tuple[Hypothesis, ...], pushes: tuple[TouchPush, ...]
) -> Hypothesis | None:
    """The hypothesis that answers for a push: the best; of two pushes, the best of its limb, or
    where both are on one limb, that of its link among the first two."""
    if len(pushes) == 1:
        return next(iter(hypotheses), None)
    limb = robot.subtree_of(push.link)
    mine = [h for h in hypotheses if robot.subtree_of(h.links[0]) == limb]
    if robot.subtree_of(pushes[0].link) == robot.subtree_of(pushes[1].link):
        return next((h for h in mine[:2] if h.links[0] == push.link), next(iter(mine), None))
    return next(iter(mine), None)


def _errors(
    watched: WatchedRobot, push: TouchPush, guess: Hypothesis | None, moment: Moment | None
) -> tuple[float, float]:
    """Distances of point [m] and force [N] in space; nan without a hypothesis."""
    if guess is None or moment is None:
        return float("nan"), float("nan")
    here, there = watched.placement(push.link), watched.placement(guess.links[0])
    elapsed = moment.elapsed
    over = elapsed < 0.0 or push.shape.ended(elapsed)
    amplitude = 0.0 if over else push.shape.amplitude(elapsed)
    point = here.act(push.point) - there.act(guess.point)
    force = amplitude * here.rotation @ push.force - there.rotation @ guess.force
    return float(np.linalg.norm(point)), float(np.linalg.norm(force))


def contact_free_score(watched: WatchedRobot, case: Case, seconds: float) -> ContactFreeScore:
    """Let a robot move untouched and return what was reported."""
    seen = watched.start_motion() + watched.watch(seconds)
    flagged = np.array([bool(sight.touched) for sight in seen])
    stamps = np.array([sight.stamp for sight in seen])[flagged] * 1e-9
    alarms = int(flagged.any()) + int((np.diff(stamps) > PAUSE).sum())
    return ContactFreeScore(
        motion=case.kind,
        seconds=seconds,
        alarms=alarms,
        flagged_share=float(flagged.mean()),
        limbs=tuple(dict.fromkeys(limb for sight in seen for limb in sight.touched)),
        fell=watched.plant.fallen,
        step_time=float(np.median(watched.step_times)),
    )
