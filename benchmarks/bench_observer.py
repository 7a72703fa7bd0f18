"""Torque observer step beside iDynTree's, from NumPy to NumPy, interleaved in one run.

A step is kinematics, wrenches and torques of iCub (32 joints, 6 sensors). The covariances of
all wrenches and torques depend on posture and contacts only, so the service computes them ten
times per second: "with covariance at 10 Hz" is a step and its share of that.
"""

import numpy as np

from benchmarks.observer_steps import step_times
from benchmarks.rows import Row, row
from robot_model import load_robot

ROUNDS = 240
RATIO, LIMIT = 0.6, 100.0  # of iDynTree's step; us
EVERY = 100  # samples at 1 kHz from one covariance to the next


def run(quick: bool = False) -> list[Row]:
    """Return medians and 99th percentiles in microseconds."""
    times = step_times(load_robot("icub"), "floor", 12 if quick else ROUNDS)
    (step, step_99), (covariance, covariance_99), (peer, peer_99) = (
        np.percentile(times[name], [50.0, 99.0]).tolist() for name in ("step", "covariance", "peer")
    )
    shared = step + covariance / EVERY
    return [
        row("torque observer step, NumPy to NumPy", step, "us", peer),
        row("torque observer step, NumPy to NumPy, p99", step_99, "us", peer_99),
        row("torque observer step by iDynTree's step", step / peer, "times", limit=RATIO),
        row("covariances of wrenches and torques at one posture", covariance, "us"),
        row("covariances of wrenches and torques at one posture, p99", covariance_99, "us"),
        row("torque observer step with covariance at 10 Hz", shared, "us", peer, limit=LIMIT),
        row("torque observer step with covariance at every sample", step + covariance, "us", peer),
    ]
