"""Torque observer step beside iDynTree's, from NumPy to NumPy, interleaved in one run."""

from collections.abc import Callable
from time import perf_counter_ns
from typing import Any

import numpy as np

from benchmarks.idyntree_observer import IdyntreeObserver
from estimation.torque_observer import TorqueObserver
from robot_model import load_robot

STATES, ROUNDS, BURST = 200, 30, 50


def run(quick: bool = False) -> list[dict[str, Any]]:
    """Return the median step of both in microseconds, and their ratio."""
    observer = TorqueObserver(load_robot("icub"))
    peer = IdyntreeObserver(observer.robot, [contact.frame for contact in observer.contacts])
    states = _states(observer)
    peer_states = [(*s[:3], -s[3], *s[4:]) for s in states]  # iDynTree: child on parent
    ours, theirs = [], []
    for _ in range(3 if quick else ROUNDS):
        for start in range(0, STATES, BURST):
            burst = slice(start, start + BURST)
            ours += _times(observer.step, states[burst])
            theirs += _times(peer.step, peer_states[burst])
    value, other = float(np.median(ours)) * 1e-3, float(np.median(theirs)) * 1e-3
    name = "torque observer step, NumPy to NumPy"
    row = {"name": name, "value": value, "unit": "us", "peer": other, "ratio": value / other}
    return [row]


def _states(observer: TorqueObserver) -> list[tuple[np.ndarray, ...]]:
    rng = np.random.default_rng(0)
    n, k = observer.robot.n, len(observer.robot.ft_sensors)
    shapes = (n, n, n, (k, 6), 3, 3, 3)  # q dq ddq ft gyro acc dgyro
    return [tuple(rng.normal(size=shape) for shape in shapes) for _ in range(STATES)]


def _times(step: Callable[..., Any], states: list[tuple[np.ndarray, ...]]) -> list[int]:
    """Durations of hot steps [ns]; the first of a burst warms the caches and is dropped."""
    step(*states[0])
    times = []
    for state in states:
        start = perf_counter_ns()
        step(*state)
        times.append(perf_counter_ns() - start)
    return times
