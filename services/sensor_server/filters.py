"""The method of differentiation that the settings ask for."""

from collections.abc import Callable
from functools import partial

from estimation.adaptive_window import AdaptiveWindow
from estimation.differentiation import Kernel, Method
from estimation.kalman_window import KalmanWindow
from estimation.sensor_pipeline import column_values
from robot_model import Robot
from services.sensor_server.config import FilterConfig, KalmanConfig


def method_of(config: FilterConfig, robot: Robot) -> Callable[[float, float], Method]:
    """Return what makes the method from the period and the delay [s]."""
    if config.method == "kalman":
        return partial(_kalman, config.kalman)
    if config.method == "adaptive":
        adaptive = config.adaptive
        bound = column_values(robot, **adaptive.bound.model_dump())
        return partial(
            AdaptiveWindow, bound=bound, order=adaptive.order, shortest=adaptive.shortest
        )
    return Kernel


def _kalman(config: KalmanConfig, period: float, delay: float) -> KalmanWindow:
    """Return the filter, if all that it says is of the instant that the delay states."""
    window = KalmanWindow(period, delay, **config.model_dump())
    if abs(window.lateness) > period:
        raise ValueError(
            f"filter.kalman: accelerations would be {1e3 * window.lateness:+.1f} ms off the "
            f"{1e3 * delay:g} ms that filter.delay states: choose half of the memory, or more jerk"
        )
    return window
