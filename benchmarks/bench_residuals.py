"""Residuals, detection and search for the place, hot, beside iDynTree's torque observer.

The peer has no residuals; its step, from NumPy to NumPy in the same run, tells how fast
the machine is. The classical residual in the manner of R builds C by repeated Newton-Euler.
Detection renews its covariances ten times a second, piece by piece: six of 25 steps do more
than the others, which the 99th percentile tells of. Steps are measured in processor time, so that
other work of a shared machine is not counted.
"""

from collections.abc import Callable
from time import thread_time_ns
from typing import Any

import numpy as np

from benchmarks.idyntree_observer import IdyntreeObserver
from benchmarks.rows import row
from estimation.contact.contact_detector import ContactDetector
from estimation.residual.residuals import FloatingResiduals
from experiments.residual_timing import newton_euler_momentum
from robot_model import Robot, load_robot
from robot_model.messages import SensorFrame

ROUNDS, BURST = 60, 50
RESIDUALS, RATIO = 40.0, 1.08  # us, both together; the same by iDynTree's step of 37 us
DETECTION, LOCATION = 300.0, 10.0  # us; ms


def run(quick: bool = False) -> list[dict[str, Any]]:
    """Return the median times [us]; steps take turns, so that all see the same machine."""
    robot = load_robot("icub")
    frames = _frames(robot)
    steps = {
        "internal and external residual step": _residual_step(robot),
        "classical residual terms as in R, C by repeated Newton-Euler": _papers_way(robot),
        "contact detection step": _detection_step(robot),
        "torque observer step of iDynTree": IdyntreeObserver.like(robot).step_frame,
    }
    times: dict[str, list[int]] = {name: [] for name in steps}
    for _ in range(5 if quick else ROUNDS):
        for name, step in steps.items():
            times[name] += _times(step, frames)
    median, slow = (
        {name: float(np.percentile(values, share)) * 1e-3 for name, values in times.items()}
        for share in (50.0, 99.0)
    )
    return _rows(median, slow) + [_location(robot, 3 if quick else 40)]


def _rows(median: dict[str, float], slow: dict[str, float]) -> list[dict[str, Any]]:
    residual, papers, detection, peer = median
    theirs = median[peer]
    return [
        row(residual, median[residual], "us", theirs, limit=RESIDUALS),
        row(f"{residual} by iDynTree's step", median[residual] / theirs, "times", limit=RATIO),
        row(detection, median[detection], "us", theirs, limit=DETECTION),
        row(f"{detection}, p99", slow[detection], "us", slow[peer]),
        row(papers, median[papers], "us"),
    ]


def _residual_step(robot: Robot) -> Callable[[SensorFrame], Any]:
    residuals = FloatingResiduals(robot)
    return lambda frame: residuals.step(
        frame.q, frame.dq, frame.motor_torque, frame.ft, frame.imu_gyro[0], frame.imu_acc[0], 1e-3
    )


def _papers_way(robot: Robot) -> Callable[[SensorFrame], Any]:
    """Columns of C from differences of Newton-Euler passes, as R section II-B says."""
    terms = newton_euler_momentum(robot.tree.model)
    return lambda frame: terms(robot.tree.configuration(frame.q), robot.tree.velocity(frame.dq))


def _detection_step(robot: Robot) -> Callable[[SensorFrame], Any]:
    detector, clock = ContactDetector(robot), iter(range(0, 2**62, 4_000_000))
    return lambda frame: detector.step(frame, next(clock))


def _location(robot: Robot, rounds: int) -> dict[str, Any]:
    """Time to locate a touch on the trunk, the sub-tree with most of the surface."""
    detector, frame = ContactDetector(robot), _frames(robot)[0]
    for stamp in range(0, 400_000_000, 4_000_000):
        detector.step(frame, stamp)
    times = []
    for _ in range(rounds):
        start = thread_time_ns()
        detector.locate(frame)
        times.append((thread_time_ns() - start) / max(1, len(detector.touched)))
    found = float(np.median(times)) * 1e-6
    return row("search for the place, per limb", found, "ms", limit=LOCATION)


def _frames(robot: Robot) -> list[SensorFrame]:
    rng = np.random.default_rng(0)
    n, k, m = (robot.dimensions[letter] for letter in "nkm")
    return [
        SensorFrame(
            q=robot.home + 0.1 * rng.normal(size=n),
            dq=rng.normal(size=n),
            ddq=rng.normal(size=n),
            motor_torque=rng.normal(size=n),
            ft=rng.normal(size=(k, 6)),
            imu_gyro=rng.normal(size=(m, 3)),
            imu_acc=np.tile([0.0, 0.0, 9.81], (m, 1)),
            imu_dgyro=rng.normal(size=(m, 3)),
            joint_valid=np.ones(n, dtype=bool),
            ft_valid=np.ones(k, dtype=bool),
            imu_valid=np.ones(m, dtype=bool),
        )
        for _ in range(BURST)
    ]


def _times(step: Callable[[SensorFrame], Any], frames: list[SensorFrame]) -> list[int]:
    """Processor time of hot steps [ns]; the first of a burst warms the caches and is dropped."""
    step(frames[0])
    times = []
    for frame in frames:
        start = thread_time_ns()
        step(frame)
        times.append(thread_time_ns() - start)
    return times
