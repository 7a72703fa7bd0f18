"""One robot in simulation, pushed again and again, watched by the contact detector."""

from dataclasses import dataclass

import numpy as np

from estimation.contact.contact_detector import ContactDetector, DetectorSettings
from estimation.contact.localisation import Localisation
from estimation.contact.quiet_period import QuietPeriod
from estimation.sensor_pipeline import SensorPipeline
from experiments.touch_pushes import TouchPush
from robot_model import Robot
from robot_model.messages import SensorFrame
from robot_sim import Plant

Array = np.ndarray
EVERY = 4  # ticks of 1 ms between samples of the detector
START, TARE, HOLD, REST = 2.0, 1.0, 0.9, 0.7  # s; a ramp rises within the first 0.5 s
NOTICEABLE = 5.0  # N, from which the delay of detection counts
RISE = 0.5  # s


@dataclass(frozen=True)
class TouchScore:
    """How one push was seen; names and places are those at its end."""

    link: str
    subtree: str
    detected: bool  # on the right limb
    elsewhere: tuple[str, ...]  # limbs that were flagged wrongly
    delay: float  # s from 5 N to the flag; nan when undetected
    ranking: tuple[str, ...]
    probability: float  # of the first hypothesis
    none_probability: float
    point_error: float  # m, of the first hypothesis, in space; nan without one
    force_error: float  # N
    force: float  # N, true

    @property
    def first(self) -> bool:
        return self.ranking[:1] == (self.link,)

    @property
    def among_three(self) -> bool:
        return self.link in self.ranking[:3]


class TouchRun:
    """A standing plant, the sensor pipeline and a tared contact detector."""

    def __init__(
        self,
        robot: Robot,
        profile: str,
        seed: int,
        settings: DetectorSettings | None = None,
        base: str = "free",
    ):
        self.robot = robot
        support = "floor" if base == "free" else "pole"
        self.plant = Plant(robot, base=base, profile=profile, seed=seed)  # type: ignore[arg-type]
        self._pipeline = SensorPipeline(robot)
        self.detector = ContactDetector(robot, support, settings)
        first = self.plant.raw()
        self._filtered = first.dq is None  # a filter needs every tick
        self.frame: SensorFrame = self._pipeline.step(first, self.plant.time)
        self.seen: dict[str, int] = {}  # first stamp of a flag, by limb
        self.advance(START)
        self.tare(TARE)

    def advance(self, seconds: float) -> None:
        """Run the plant and the detector, remembering flags."""
        for tick in range(round(seconds * 1000)):
            self.plant.step()
            due = tick % EVERY == EVERY - 1
            if due or self._filtered:
                self.frame = self._pipeline.step(self.plant.raw(), self.plant.time)
            if due and self.frame.joint_valid.all():
                self._watch()

    def _watch(self) -> None:
        for flag in self.detector.step(self.frame, self.plant.time):
            if flag.state != "none":
                self.seen.setdefault(flag.limb, self.plant.time)

    def tare(self, seconds: float) -> None:
        """Tare the detector on the resting robot."""
        quiet = QuietPeriod(self.robot.joints)
        for _ in range(round(seconds * 1000 / EVERY)):
            self.advance(EVERY * 1e-3)
            rows = self.detector.untared_rows
            wrenches = self.detector.rows.wrenches(rows)
            quiet.add(self.frame, rows, self.detector.rows.predicted, wrenches, np.zeros(0))
        self.detector.tare(quiet.finish())

    def score(self, push: TouchPush) -> TouchScore:
        """Push, locate the touch at the end of the hold, release, and let the robot settle."""
        self.seen = {}
        start = self.plant.time
        self.plant.push(push.link, push.point, push.force, profile="ramp")
        self.advance(HOLD)
        located = self.detector.locate(self.frame)
        score = self._judge(push, located, start)
        self.plant.release()
        self.advance(REST)
        return score

    def _judge(self, push: TouchPush, located: Localisation, start: int) -> TouchScore:
        subtree = self.robot.subtrees[self.robot.subtree_of(push.link)].name
        size = float(np.linalg.norm(push.force))
        noticeable = start * 1e-9 + RISE * min(1.0, NOTICEABLE / size)
        delay = self.seen[subtree] * 1e-9 - noticeable if subtree in self.seen else np.nan
        point_error, force_error = self._errors(push, located)
        first = located.hypotheses[0] if located.hypotheses else None
        return TouchScore(
            link=push.link,
            subtree=subtree,
            detected=subtree in self.seen,
            elsewhere=tuple(limb for limb in self.seen if limb != subtree),
            delay=delay,
            ranking=tuple(h.links[0] for h in located.hypotheses),
            probability=first.probability if first else 0.0,
            none_probability=located.none_probability,
            point_error=point_error,
            force_error=force_error,
            force=size,
        )

    def _errors(self, push: TouchPush, located: Localisation) -> tuple[float, float]:
        if not located.hypotheses:
            return float("nan"), float("nan")
        best = located.hypotheses[0]
        places = dict(zip(self.robot.links, self.detector.rows.place_links(), strict=True))
        true, guess = places[push.link], places[best.links[0]]
        point = true.act(push.point) - guess.act(best.point)
        force = true.rotation @ push.force - guess.rotation @ best.force
        return float(np.linalg.norm(point)), float(np.linalg.norm(force))
