"""One robot in simulation, watched by the contact detector as its service would.

All that the benchmark asks of the detector is asked here.
"""

import time
from dataclasses import dataclass, replace
from typing import Any, Protocol

import numpy as np

from estimation.contact.contact_detector import ContactDetector, DetectorSettings
from estimation.contact.limb_monitor import LimbFlag
from estimation.contact.localisation import Localisation
from estimation.contact.quiet_period import Quiet, QuietPeriod
from estimation.sensor_pipeline import SensorPipeline
from experiments.touch.cases import Case
from experiments.touch.conditions import VARIANTS, Condition, Variant
from experiments.touch.motions import drawn_motion
from robot_model import Robot
from robot_model.messages import RawFrame
from robot_sim import Plant
from robot_sim.motions import Motion

Array = np.ndarray
EVERY = 4  # ticks of 1 ms between samples of the detector
LOCATE = 12  # samples between localisations of a held touch, about 20 Hz
SETTLE, FILL, TARE, FADE, CALIBRATE = 1.5, 0.1, 1.0, 2.0, 8.0  # s


class TouchPlant(Protocol):
    """What a run needs of a plant."""

    time: int  # ns

    @property
    def fallen(self) -> bool: ...
    def step(self) -> None: ...
    def raw(self) -> RawFrame: ...
    def motion(self, motion: Motion | None) -> None: ...
    def push(
        self,
        link: str,
        point: Array,
        force: Array,
        *,
        profile: str,
        duration: float,
        rise: float,
    ) -> Any: ...
    def release(self) -> Any: ...


@dataclass(frozen=True, eq=False)
class Sight:
    """What the detector says of one sample."""

    stamp: int  # ns
    touched: tuple[str, ...]  # limbs
    force: float  # N, largest of a touched limb
    located: Localisation | None = None


class WatchedRobot:
    """A plant under a condition, the sensor pipeline and a detector, tared if it is to be.

    Args:
        robot: The robot as it is.
        case: Seed and motion; it is still until ``start_motion``.
        condition: Physics, noise, errors and method.
    """

    flags: list[LimbFlag]  # of the last sample

    def __init__(self, robot: Robot, case: Case, condition: Condition):
        self.robot, self.case = robot, case
        self.variant = VARIANTS[condition.variant]
        self.plant = _plant(robot, case, condition, self.variant)
        self._gain = _gains(robot, case.noise, self.variant.gain_error)
        believed = robot.perturbed(case.noise, self.variant.mass_error)
        support = "floor" if case.base == "free" else "pole"
        settings = DetectorSettings(method=condition.method)
        self._pipeline = SensorPipeline(robot)
        self.detector = ContactDetector(believed, support, settings)
        self._limbs = self.detector.monitor.limbs
        self.step_times: list[float] = []  # s
        self.locate_times: list[float] = []  # s
        self._samples = 0
        for _ in range(round(SETTLE * 1000)):
            self.plant.step()
        self.watch(FILL)
        self._tare(TARE)
        if self.variant.calibrated:
            self._calibrate(CALIBRATE)

    def watch(self, seconds: float, locate: bool = False) -> list[Sight]:
        """Run plant and detector and return what is seen; with places where wanted."""
        seen = []
        for tick in range(round(seconds * 1000)):
            self.plant.step()
            self.frame = self._pipeline.step(self._raw(), self.plant.time)
            if tick % EVERY == EVERY - 1 and self.frame.joint_valid.all():
                seen.append(self._look(locate))
        return seen

    def start_motion(self) -> list[Sight]:
        """Begin the motion of the case and wait until it is there."""
        if self.case.motion is None:
            return self.watch(self.case.wait)
        self.plant.motion(self.case.motion)
        return self.watch(FADE + self.case.wait)

    @property
    def delay(self) -> float:
        """Age of what the frame describes [s]."""
        return self.frame.delay

    def placement(self, link: str) -> Any:
        """Placement of a link in the axes of the root, as the detector knows it."""
        links = self.detector.rows.robot.links
        return self.detector.rows.place_links()[links.index(link)]

    def _raw(self) -> RawFrame:
        raw = self.plant.raw()
        return raw if self._gain is None else replace(raw, ft=raw.ft * self._gain)

    def _look(self, locate: bool) -> Sight:
        start = time.perf_counter()
        self.flags = flags = self.detector.step(self.frame, self.plant.time)
        self.step_times.append(time.perf_counter() - start)
        touched = self.detector.touched
        self._samples = self._samples + 1 if touched else 0
        names = tuple(self._limbs[i] for i in touched)
        force = max((flags[i].force for i in touched), default=0.0)
        due = locate and self._samples % LOCATE == 1
        return Sight(self.plant.time, names, force, self._locate() if due else None)

    def locate(self) -> Localisation | None:
        """Locate what is touched now; None without a touch."""
        return self._locate() if self.detector.touched else None

    def _locate(self) -> Localisation:
        start = time.perf_counter()
        located = self.detector.locate(self.frame)
        self.locate_times.append(time.perf_counter() - start)
        return located

    def _tare(self, seconds: float) -> None:
        """Tare the detector on the resting robot; without a tare let the time pass."""
        quiet = self._quiet(seconds)
        if self.variant.tared:
            self.detector.tare(quiet)

    def _calibrate(self, seconds: float) -> None:
        """Learn from the motion of another case in which nothing touches."""
        random = np.random.default_rng(self.case.noise)
        kind = "pole" if self.case.base == "fixed" else "every joint"
        motion = drawn_motion(self.robot, kind, random)
        assert motion is not None
        self.plant.motion(motion)
        self.watch(FADE)
        self.detector.calibrate(self._quiet(seconds))
        self.plant.motion(None)  # another one that began now would tear at the limbs
        self.watch(FADE)

    def _quiet(self, seconds: float) -> Quiet:
        period, rows = QuietPeriod(self.robot.joints), self.detector.rows
        for _ in range(round(seconds * 1000 / EVERY)):
            self.watch(EVERY * 1e-3)
            raw, tared = self.detector.untared_rows, self.detector.tared_rows
            wrenches = rows.wrenches(raw)
            period.add(self.frame, raw, rows.predicted, wrenches, np.zeros(0), tared)
        return period.finish(still=False)


def _plant(robot: Robot, case: Case, condition: Condition, variant: Variant) -> TouchPlant:
    profile = condition.profile
    if variant.friction:
        if profile != "realistic":
            raise ValueError(f"friction needs the profile 'realistic', got '{profile}'")
        profile = "realistic_friction"
        robot = replace(robot, coulomb=np.full(robot.n, variant.friction))
    if condition.physics == "pinocchio":
        return Plant(robot, case.base, profile, case.noise)  # type: ignore[arg-type,return-value]
    from experiments.mujoco_plant import MujocoPlant

    return MujocoPlant(robot, case.base, profile, case.noise)


def _gains(robot: Robot, seed: int, error: float) -> Array | None:
    if not error:
        return None
    return 1.0 + np.random.default_rng(seed).normal(0.0, error, (len(robot.ft_sensors), 6))
