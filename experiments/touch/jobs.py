"""Runs of the benchmark one after the other, or in processes side by side."""

import math
import multiprocessing
from collections.abc import Iterator, Sequence
from dataclasses import asdict
from typing import Any

from experiments.touch.cases import contact_free_case, pushed_case
from experiments.touch.conditions import VARIANTS
from experiments.touch.pushes import PushGenerator
from experiments.touch.scores import contact_free_score, push_score
from experiments.touch.store import Item, Record
from experiments.touch.watched_robot import WatchedRobot
from robot_model import Robot, load_robot

FREE = 60.0  # s of contact-free motion in one run
DIGITS = 6


class Runner:
    """Performs runs on one robot."""

    def __init__(self, robot: Robot):
        self._robot, self._generator = robot, PushGenerator(robot)

    def perform(self, item: Item) -> Record:
        """Return the result of a run as JSON carries it."""
        robot, (what, seed, index, condition) = self._robot, item
        if what == "free":
            case = contact_free_case(robot, seed, index)
            score = contact_free_score(WatchedRobot(robot, case, condition), case, FREE)._asdict()
        else:
            contacts = VARIANTS[condition.variant].contacts
            case = pushed_case(self._generator, robot, seed, index, contacts)
            score = asdict(push_score(robot, WatchedRobot(robot, case, condition), case))
        return {name: rounded(value) for name, value in score.items()}


def performed(robot: Robot, items: Sequence[Item], jobs: int) -> Iterator[tuple[Item, Record]]:
    """Perform runs and yield each as it ends; in processes of their own when jobs > 1."""
    if jobs == 1 or len(items) < 2:
        runner = Runner(robot)
        yield from ((item, runner.perform(item)) for item in items)
        return
    context = multiprocessing.get_context("spawn")
    with context.Pool(min(jobs, len(items)), _start, (str(robot.source),)) as pool:
        yield from pool.imap_unordered(_perform, items)


_runner: Runner  # of a process of the pool


def _start(source: str) -> None:
    global _runner
    _runner = Runner(load_robot(source))


def _perform(item: Item) -> tuple[Item, Record]:
    return item, _runner.perform(item)


def rounded(value: Any) -> Any:
    """Numbers with six digits, and null for those that are not finite."""
    if isinstance(value, tuple | list):
        return [rounded(entry) for entry in value]
    if isinstance(value, float):
        return float(f"{value:.{DIGITS}g}") if math.isfinite(value) else None
    return value
