"""Durations of steps whose code and data are in the caches."""

from collections.abc import Callable, Mapping, Sequence
from time import perf_counter_ns
from typing import Any

BURST = 50  # steps in a row, before somebody else has a turn


def interleaved(
    steps: Mapping[str, Callable[..., Any]], inputs: Mapping[str, Sequence[tuple]], rounds: int
) -> dict[str, list[float]]:
    """Return the durations [us] of each step; they take turns, so all see the same machine."""
    times: dict[str, list[float]] = {name: [] for name in steps}
    for turn in range(rounds):
        for name, step in steps.items():
            start = turn * BURST % len(inputs[name])
            times[name] += burst(step, inputs[name][start : start + BURST])
    return times


def burst(step: Callable[..., Any], inputs: Sequence[tuple]) -> list[float]:
    """Return durations [us]; the first step warms the caches and is done twice."""
    step(*inputs[0])
    times = []
    for arguments in inputs:
        start = perf_counter_ns()
        step(*arguments)
        times.append((perf_counter_ns() - start) * 1e-3)
    return times
