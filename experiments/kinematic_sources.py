"""Kinematic sources compared: the head's inertial sensor, all sensors fused, a fixed link.

iCub hangs on its pole and moves; its observer knows where nothing touches. F/T offsets are
taken off exactly, so that what is left is the noise of F/T sensors, joints and source.
"""

from collections import deque
from collections.abc import Sequence
from typing import Any

import numpy as np

from estimation.kinematic_source import FUSION, KinematicSource
from estimation.sensor_pipeline import SensorPipeline
from estimation.torque_observer import Estimate, TorqueObserver
from experiments.report import Report, markdown_table
from robot_model import Robot
from robot_model.messages import GroundTruth
from robot_sim import Plant
from robot_sim.motions import Motion, Sinusoid

Array = np.ndarray
EVERY = 5  # ticks of 1 ms between compared samples
NAME, PROFILE = "kinematic_sources", "realistic"
SETTLE, COMPARED = 1.0, 3.0  # s at the beginning that are not compared, and then are
REFRESH = 0.1  # s between weights, as in the service
QUANTITIES = ("ft_force", "ft_moment", "wrench_force", "wrench_moment", "torque")
COLUMNS = ("F/T [N]", "F/T [N m]", "wrench [N]", "wrench [N m]", "torque [N m]")
MOTIONS = {
    "arms, torso and legs": ("torso", "left_arm", "right_arm", "left_leg", "right_leg"),
    "all, the head fastest": ("torso", "left_arm", "right_arm", "left_leg", "right_leg", "head"),
}


def moving(robot: Robot, parts: Sequence[str], seed: int) -> Motion:
    """Return sinusoids on all joints of some parts, the head's faster than the others'."""
    random = np.random.default_rng(seed)
    joints = {}
    for part in parts:
        low, high = (1.0, 2.0) if part == "head" else (0.3, 0.8)  # Hz
        for i in robot.parts[part]:
            frequency, phase = random.uniform(low, high), random.uniform(0.0, 6.28)
            sinusoid = Sinusoid(amplitude=0.2, frequency=frequency, phase=phase)
            joints[robot.joints[i]] = sinusoid
    return Motion("moving", joints)


def errors(estimate: Estimate, truth: GroundTruth) -> dict[str, Array]:
    """Return errors of predicted readings, external wrenches where nothing touches, torques."""
    predicted = estimate.predicted - truth.ft
    wrench = estimate.subtree_wrench[1:]
    return {
        "ft_force": predicted[:, :3].ravel(),
        "ft_moment": predicted[:, 3:].ravel(),
        "wrench_force": wrench[:, :3].ravel(),
        "wrench_moment": wrench[:, 3:].ravel(),
        "torque": estimate.torque - truth.link_torque,
    }


class SourceRun:
    """One moving robot on its pole, seen through several kinematic sources."""

    def __init__(self, robot: Robot, motion: Motion, profile: str, seed: int):
        self._plant = Plant(robot, base="fixed", profile=profile, seed=seed)
        self._plant.motion(motion)
        self._pipeline = SensorPipeline(robot)
        self._observer = TorqueObserver(robot, "pole")
        n, k = robot.n, len(robot.ft_sensors)
        self._observer.offset = self._plant.noise.bias[: 6 * k].reshape(k, 6)
        names = (robot.imus[0], FUSION, f"fixed:{robot.base_link}")
        self._sources = {name: KinematicSource(robot, name) for name in names}
        self._truths: deque[GroundTruth] = deque(maxlen=25)
        self.errors: dict[str, list[dict[str, Array]]] = {name: [] for name in names}
        self._still = np.zeros(n)

    def run(self, seconds: float) -> None:
        """Move on; what lies in the first second is not compared."""
        for tick in range(round(1000 * (SETTLE + seconds))):
            self._plant.step()
            frame = self._pipeline.step(self._plant.raw(), self._plant.time)
            self._truths.append(self._plant.truth())
            if tick < 1000 * SETTLE or tick % EVERY:
                continue
            truth = self._truths[-1 - round(1000 * frame.delay)]
            for name, source in self._sources.items():
                if tick % round(1000 * REFRESH) == 0:
                    source.refresh(frame.q)
                motion = source.step(frame).motion
                seen = self._observer.step(frame.q, frame.dq, frame.ddq, frame.ft, *motion)
                self.errors[name].append(errors(seen, truth))


def run(robot: Robot, seed: int = 11, runs: int = 5, seconds: float = COMPARED) -> Report:
    """Compare the first inertial sensor with all of them fused, and with a fixed base.

    Args:
        robot: A robot with several inertial sensors, as ``icub_inertial``.
        seed: Of motions and of the sensors' errors; biases are drawn anew in each run.
        runs: Runs per motion.
        seconds: Compared time of a run.

    Raises:
        ValueError: The robot has one inertial sensor only, or there is no run.
    """
    if len(robot.imus) < 2 or runs < 1:
        raise ValueError(
            f"expected several inertial sensors and at least 1 run, got {len(robot.imus)} of"
            f" {robot.name} and {runs}; try --robot icub_inertial"
        )
    rows = _compare(robot, seed, runs, seconds)
    table = _table(rows)
    return Report(
        name=NAME,
        figures={"robot": robot.name, "seed": seed, "runs": runs, "rows": rows},
        lines=["root mean square / largest error", *table.splitlines()],
        files={f"{NAME}.md": f"# Kinematic sources: rms / largest error\n\n{table}"},
    )


def _compare(robot: Robot, seed: int, runs: int, seconds: float) -> list[dict[str, Any]]:
    """Return rows: motion, source, quantity, rms and largest error over all runs."""
    rows = []
    for label, parts in MOTIONS.items():
        pooled: dict[str, list[dict[str, Array]]] = {}
        for index in range(seed, seed + runs):
            source_run = SourceRun(robot, moving(robot, parts, index), PROFILE, index)
            source_run.run(seconds)
            for name, found in source_run.errors.items():
                pooled.setdefault(name, []).extend(found)
        rows += [_row(label, name, key, found) for name, found in pooled.items()
                 for key in QUANTITIES]  # fmt: skip
    return rows


def _row(motion: str, source: str, key: str, found: list[dict[str, Array]]) -> dict[str, Any]:
    values = np.concatenate([sample[key] for sample in found])
    rms, largest = float(np.sqrt(np.mean(values**2))), float(np.abs(values).max())
    return {"motion": motion, "source": source, "quantity": key, "rms": rms, "max": largest}


def _table(rows: Sequence[dict[str, Any]]) -> str:
    """Return the rows as a Markdown table, rms / largest error."""
    cells = []
    for start in range(0, len(rows), len(QUANTITIES)):
        group = rows[start : start + len(QUANTITIES)]
        errors = [f"{row['rms']:.3f} / {row['max']:.2f}" for row in group]
        cells.append([group[0]["motion"], group[0]["source"], *errors])
    return markdown_table(["motion", "source", *COLUMNS], cells)
