"""What residuals cost, and what makes R's "16 times".

R times its internal residual against a classical one whose Coriolis matrix C is built
by one Newton-Euler pass per column. That is the slow way to C: both ways are timed here.
"""

from collections.abc import Callable
from time import perf_counter_ns

import numpy as np
import pinocchio as pin

from estimation.residual.floating_terms import floating_terms
from robot_model import Robot

Array = np.ndarray
State = tuple[Array, Array]  # q and v of the floating-base model
Step = Callable[[Array, Array], object]


def timings(robot: Robot, seed: int, states: int) -> list[tuple[str, float, float]]:
    """Return each way's median time [us] and its ratio to the internal residual's; steps take
    turns, so that all see the same machine."""
    model = robot.tree.model
    steps: dict[str, Step] = {
        "internal and external": _floating(model),
        "internal, all matrices of (13) formed": _literal(model),
        "classical": _classical(model),
        "classical, C by repeated Newton-Euler": newton_euler_momentum(model),
    }
    times: dict[str, list[int]] = {name: [] for name in steps}
    for q, v in _states(model, seed, states):
        for name, step in steps.items():
            step(q, v)  # warms the caches
            start = perf_counter_ns()
            step(q, v)
            times[name].append(perf_counter_ns() - start)
    median = {name: float(np.median(values)) * 1e-3 for name, values in times.items()}
    ours = median["internal and external"]
    return [(name, value, value / ours) for name, value in median.items()]


def _states(model: pin.Model, seed: int, count: int) -> list[State]:
    random = np.random.default_rng(seed)
    neutral = pin.neutral(model)
    moved = (
        np.concatenate((np.zeros(6), random.uniform(-1, 1, model.nv - 6))) for _ in range(count)
    )
    return [(pin.integrate(model, neutral, step), random.normal(size=model.nv)) for step in moved]


def _floating(model: pin.Model) -> Step:
    data, force = model.createData(), np.zeros(model.nv)

    def step(q: Array, v: Array) -> object:
        mass = pin.crba(model, data, q, pin.Convention.WORLD)
        coriolis = pin.computeCoriolisMatrix(model, data, q, v)
        return floating_terms(mass, coriolis, v, force, force)

    return step


def _literal(model: pin.Model) -> Step:
    """R eqs. (11) and (13) as they stand; the rate of M from C."""
    data = model.createData()

    def step(q: Array, v: Array) -> object:
        mass = pin.crba(model, data, q, pin.Convention.WORLD)
        coriolis = pin.computeCoriolisMatrix(model, data, q, v)
        rate = coriolis + coriolis.T
        inverse, f, df = np.linalg.inv(mass[:6, :6]), mass[:6, 6:], rate[:6, 6:]
        gives = inverse @ f
        floating = mass[6:, 6:] - f.T @ gives
        change = rate[6:, 6:] - df.T @ gives - gives.T @ df + gives.T @ rate[:6, :6] @ gives
        bias = coriolis @ v
        return floating @ v[6:], change @ v[6:] - bias[6:] + gives.T @ bias[:6]

    return step


def _classical(model: pin.Model) -> Step:
    data = model.createData()

    def step(q: Array, v: Array) -> object:
        mass = pin.crba(model, data, q, pin.Convention.WORLD)
        coriolis = pin.computeCoriolisMatrix(model, data, q, v)
        return mass @ v, v @ coriolis

    return step


def newton_euler_momentum(model: pin.Model) -> Step:
    """Columns of H and of C by one Newton-Euler pass each, as R section II-B says."""
    data = model.createData()
    zero, units = np.zeros(model.nv), np.eye(model.nv)

    def step(q: Array, v: Array) -> Array:
        gravity = pin.rnea(model, data, q, zero, zero).copy()
        mass = np.array([pin.rnea(model, data, q, zero, unit) - gravity for unit in units])
        both = np.array([pin.rnea(model, data, q, v + unit, zero).copy() for unit in units])
        return mass @ v + both @ v

    return step
