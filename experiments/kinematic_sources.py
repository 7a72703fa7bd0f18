"""Kinematic sources compared: the head's inertial sensor, all sensors fused, a fixed link.

iCub hangs on its pole and moves; its observer knows where nothing touches. F/T offsets are
taken off exactly, so that what is left is the noise of F/T sensors, joints and source.

``python -m experiments.kinematic_sources --seed 1 --runs 4``
"""

import argparse
import json
import sys
from collections import deque
from collections.abc import Sequence
from pathlib import Path
from typing import Any

import numpy as np

from estimation.kinematic_source import FUSION, KinematicSource
from estimation.sensor_pipeline import SensorPipeline
from estimation.torque_observer import Estimate, TorqueObserver
from robot_model import Robot, load_robot
from robot_model.messages import GroundTruth
from robot_sim import Plant
from robot_sim.motions import Motion, Sinusoid

Array = np.ndarray
EVERY = 5  # ticks of 1 ms between compared samples
SETTLE = 1.0  # s
REFRESH = 0.1  # s between weights, as in the service
QUANTITIES = ("ft_force", "ft_moment", "wrench_force", "wrench_moment", "torque")
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


def compare(
    robot: Robot, seed: int, runs: int, seconds: float, profile: str = "realistic"
) -> list[dict[str, Any]]:
    """Return rows: motion, source, quantity, rms and largest error over all runs.

    Args:
        robot: A robot with several inertial sensors.
        seed: Of motions and of the sensors' errors; biases are drawn anew in each run.
        runs: Runs per motion.
        seconds: Compared time of a run.
        profile: Noise profile of the plant.
    """
    rows = []
    for label, parts in MOTIONS.items():
        pooled: dict[str, list[dict[str, Array]]] = {}
        for index in range(seed, seed + runs):
            run = SourceRun(robot, moving(robot, parts, index), profile, index)
            run.run(seconds)
            for name, found in run.errors.items():
                pooled.setdefault(name, []).extend(found)
        rows += [_row(label, name, key, found) for name, found in pooled.items()
                 for key in QUANTITIES]  # fmt: skip
    return rows


def _row(motion: str, source: str, key: str, found: list[dict[str, Array]]) -> dict[str, Any]:
    values = np.concatenate([sample[key] for sample in found])
    rms, largest = float(np.sqrt(np.mean(values**2))), float(np.abs(values).max())
    return {"motion": motion, "source": source, "quantity": key, "rms": rms, "max": largest}


def table(rows: Sequence[dict[str, Any]]) -> list[str]:
    """Return the rows as a Markdown table, rms / largest error."""
    lines = ["| motion | source | F/T N | F/T N m | wrench N | wrench N m | torque N m |"]
    lines += ["|---" * 7 + "|"]
    for start in range(0, len(rows), len(QUANTITIES)):
        group = rows[start : start + len(QUANTITIES)]
        cells = [f"{row['rms']:.3f} / {row['max']:.2f}" for row in group]
        lines.append(f"| {group[0]['motion']} | {group[0]['source']} | " + " | ".join(cells) + " |")
    return lines


def main(arguments: Sequence[str] | None = None) -> None:
    parser = argparse.ArgumentParser(prog="python -m experiments.kinematic_sources")
    parser.add_argument("--robot", default="icub_inertial", help="name or path of a description")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--runs", type=int, default=4, help="runs per motion")
    parser.add_argument("--seconds", type=float, default=3.0, help="compared time of a run")
    parser.add_argument("--profile", default="realistic", help="noise profile of the plant")
    parser.add_argument("--json", action="store_true", help="print one JSON document")
    parser.add_argument("-o", "--output", type=Path, help="folder for kinematic_sources.json")
    options = parser.parse_args(sys.argv[1:] if arguments is None else arguments)
    robot = load_robot(options.robot)
    rows = compare(robot, options.seed, options.runs, options.seconds, options.profile)
    document = json.dumps({"seed": options.seed, "runs": options.runs, "rows": rows}, indent=1)
    if options.output is not None:
        options.output.mkdir(parents=True, exist_ok=True)
        (options.output / "kinematic_sources.json").write_text(document + "\n")
    print(document if options.json else "\n".join(table(rows)))


if __name__ == "__main__":
    main()
