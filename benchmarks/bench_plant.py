"""The plant with its sensors, hot: wall time per tick of 1 ms, and how much faster than real."""

from time import perf_counter_ns
from typing import Any

import numpy as np

from robot_model import load_robot
from robot_sim import TICK, Plant

WARM_UP, TICKS = 500, 10_000  # each timed alone: a median that a busy machine spoils least
TARGET = 4.0  # times real time


def run(quick: bool = False) -> list[dict[str, Any]]:
    """Return the time per tick, standing with noisy sensors, and the real-time factor."""
    plant = Plant(load_robot("icub"), profile="realistic")
    _times(plant, WARM_UP)
    times = _times(plant, TICKS // 5 if quick else TICKS)
    tick = float(np.median(times))
    factor = TICK / 1e3 / tick
    name = "plant, tick with sensors"
    return [
        {"name": name, "value": tick, "unit": "us"},
        {
            "name": f"{name}, 99th percentile",
            "value": float(np.percentile(times, 99)),
            "unit": "us",
        },
        {
            "name": "plant with sensors, faster than real time",
            "value": factor,
            "unit": "times",
            "target": f">= {TARGET:g}",
            "met": factor >= TARGET,
        },
    ]


def _times(plant: Plant, ticks: int) -> list[float]:
    """Return the wall time of each of some ticks [us]."""
    times = []
    for _ in range(ticks):
        start = perf_counter_ns()
        plant.step()
        plant.raw()
        times.append((perf_counter_ns() - start) / 1e3)
    return times
