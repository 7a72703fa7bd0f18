"""The plant with its sensors, hot: wall time per tick of 1 ms, and how much faster than real."""

from time import perf_counter_ns
from typing import Any

import numpy as np

from robot_model import load_robot
from robot_sim import TICK, Plant

BLOCKS, BLOCK = 100, 100  # ticks are timed in blocks, whose median a busy machine spoils less
TARGET = 4.0  # times real time


def run(quick: bool = False) -> list[dict[str, Any]]:
    """Return the time per tick, standing with noisy sensors, and the real-time factor."""
    plant = Plant(load_robot("icub"), profile="realistic")
    blocks = BLOCKS // 5 if quick else BLOCKS
    times = [_block(plant) for _ in range(blocks + 5)][5:]
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


def _block(plant: Plant) -> float:
    """Return the mean time per tick of one block [us]."""
    start = perf_counter_ns()
    for _ in range(BLOCK):
        plant.step()
        plant.raw()
    return (perf_counter_ns() - start) / BLOCK / 1e3
