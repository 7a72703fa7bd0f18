"""Torque observer step on robots of 7 to 100 joints and 1 to 12 force/torque sensors.

The robots are generated: one limb per sensor, of as many joints as there are for it, the
sensor beyond its first joint. Cells: median / 99th percentile; x is the ratio to iDynTree
on the same robot in the same run. On a shared machine the percentile tells of its other work.
"""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np

from benchmarks.observer_steps import step_times
from benchmarks.rows import Row, row
from tests.estimation.random_robots import limbed_robot

JOINTS = (7, 16, 32, 64, 100)  # with 2 sensors
SENSORS = (1, 2, 4, 6, 12)  # with 36 joints
ROUNDS = 40


def run(quick: bool = False) -> list[Row]:
    """Return medians and 99th percentiles in microseconds."""
    sizes = [("joints", n, 2) for n in JOINTS] + [("sensors", 36, k) for k in SENSORS]
    return [figure for size in sizes for figure in _measured(*size, 6 if quick else ROUNDS)]


def _measured(grows: str, joints: int, sensors: int, rounds: int) -> list[Row]:
    with TemporaryDirectory() as directory:
        robot = limbed_robot(Path(directory), joints, sensors)
        times = step_times(robot, "none", rounds)
    line = f"{joints} joints, {sensors} F/T"
    found = {name: np.percentile(values, [50.0, 99.0]) for name, values in times.items()}
    rows = []
    for name, column in {"step": "ours", "peer": "iDynTree", "covariance": "covariance"}.items():
        for i, statistic in enumerate(("p50", "p99")):
            peer = float(found["peer"][i]) if name == "step" else None
            label = f"torque observer, {line}, {column}, {statistic}"
            cell = f"growth with {grows} [us]", line, column
            rows.append(row(label, float(found[name][i]), "us", peer, cell=cell))
    return rows
