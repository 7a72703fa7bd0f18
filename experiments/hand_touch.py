"""Known wrenches at the end of a limb: what is true and what the observers tell."""

from collections.abc import Sequence
from typing import NamedTuple

import numpy as np

from estimation.torque_observer import Estimate
from experiments.conditions import Case
from experiments.pole_run import PoleRun
from experiments.stimulus import PERIOD, Stimulated, Stimulus
from robot_model import Robot
from robot_sim.plant import TICK

Array = np.ndarray
EVERY = 10  # ticks of 1 ms between samples
RESTING = 200  # ticks over which the torques of the resting robot are averaged


class Sample(NamedTuple):
    """True or estimated: external wrench (6,), external torques (n,), link torques (n,)."""

    wrench: Array
    external_torque: Array
    link_torque: Array


class Limb(NamedTuple):
    """The limb whose end is touched: its sub-tree's index, end frame and joints."""

    subtree: int
    frame: str
    joints: Array


def first_limb(robot: Robot) -> Limb:
    """Return the limb of the first force/torque sensor."""
    part = next(p for p, sensors in robot.part_sensors.items() if 0 in sensors)
    return Limb(1, robot.subtrees[1].default_frame, robot.parts[part])


def touch(
    pole_run: PoleRun[Case], limb: Limb, exerted: Sequence[Stimulus]
) -> dict[Case, tuple[Sample, Sample]]:
    """Exert one after the other; return truth and estimate of the same instants, by case."""
    stimulated = Stimulated(pole_run.robot, limb.frame)
    recording = _Recording(pole_run, stimulated)
    for stimulus in exerted:
        stimulated.push(pole_run.plant, stimulus)
        for _ in range(round(PERIOD * 1e3)):
            pole_run.tick()
            recording.look()
    return recording.pairs(limb)


class _Recording:
    """Samples of a run; what the observers tell comes later than the truth of an instant."""

    def __init__(self, pole_run: PoleRun[Case], stimulated: Stimulated):
        self._run, self._stimulated = pole_run, stimulated
        self._resting = self._torques_at_rest()
        self._begin = pole_run.plant.time
        self._truth: dict[int, Sample] = {}
        self._told: dict[int, dict[Case, Estimate]] = {}

    def _torques_at_rest(self) -> dict[Case, Array]:
        torques: dict[Case, list[Array]] = {case: [] for case in self._run.observers}
        for _ in range(RESTING):
            self._run.tick()
            for case, estimate in self._run.estimates().items():
                torques[case].append(estimate.torque)
        return {case: np.mean(samples, axis=0) for case, samples in torques.items()}

    def look(self) -> None:
        """Take what is due at this tick."""
        run, plant = self._run, self._run.plant
        ticks = (plant.time - self._begin) // TICK
        if ticks % EVERY == 0:
            self._told[run.instant] = run.estimates()
        if (ticks + run.lag) % EVERY == 0:
            truth = plant.truth()
            exact = Sample(*self._stimulated.truth(truth), truth.link_torque)
            self._truth[plant.time] = exact

    def pairs(self, limb: Limb) -> dict[Case, tuple[Sample, Sample]]:
        """Truth and estimate of the instants of which both are known, by case."""
        both = [instant for instant in self._told if instant in self._truth]
        exact = _stacked([self._truth[instant] for instant in both])
        return {
            case: (exact, _stacked([_sample(self._told[t][case], limb, rest) for t in both]))
            for case, rest in self._resting.items()
        }


def _sample(estimate: Estimate, limb: Limb, resting: Array) -> Sample:
    # A link torque balances what the world exerts: F's sign of the torque is the other one.
    external = resting - estimate.torque
    return Sample(estimate.wrench[limb.subtree], external, estimate.torque)


def _stacked(samples: list[Sample]) -> Sample:
    return Sample(*(np.array(values) for values in zip(*samples, strict=True)))
