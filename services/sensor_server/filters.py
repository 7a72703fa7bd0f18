"""The method of differentiation that the settings ask for."""

from collections.abc import Callable
from functools import partial

from estimation.adaptive_window import AdaptiveWindow
from estimation.differentiation import Kernel, Method
from estimation.kalman_window import KalmanWindow
from estimation.sensor_pipeline import column_values
from robot_model import Robot
from services.sensor_server.config import FilterConfig


def method_of(config: FilterConfig, robot: Robot) -> Callable[[float, float], Method]:
    """Return what makes the method from the period and the delay [s]."""
    if config.method == "kalman":
        return partial(KalmanWindow, **config.kalman.model_dump())
    if config.method == "adaptive":
        adaptive = config.adaptive
        bound = column_values(robot, **adaptive.bound.model_dump())
        return partial(
            AdaptiveWindow, bound=bound, order=adaptive.order, shortest=adaptive.shortest
        )
    return Kernel
