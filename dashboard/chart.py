"""The chart of one residual against its threshold."""

import numpy as np
import viser
from viser import uplot

from robot_model import Robot
from robot_model.messages import Residuals

from .history import History

Array = np.ndarray

BASE_AXES = ("fx", "fy", "fz", "mx", "my", "mz")
TEXT, LINES = "#c9d1d9", "#ffffff18"
HEIGHT = 150  # [px]


class ResidualChart:
    """Remembers all residuals, draws the chosen one.

    Joints show the internal residual, or the classical one while only that is valid
    (a robot on a pole); the base shows the external residual.
    """

    def __init__(self, gui: viser.GuiApi, robot: Robot, points: int, seconds: float):
        self._joints = robot.n
        self._options = (*robot.joints, *(f"base {axis}" for axis in BASE_AXES))
        self._residuals = History(points, len(self._options))
        self._thresholds = History(points, len(self._options))
        self._choice = gui.add_dropdown("Residual", self._options)
        self._unit = ""
        nothing = np.array([-seconds, 0.0])
        self._plot = gui.add_uplot(
            (nothing, 0.0 * nothing, 0.0 * nothing, 0.0 * nothing),
            _series("residual"),
            # a range of its own: viser follows data with a zoom that may go wrong for good
            scales={
                "x": uplot.Scale(time=False, range=(-seconds, 0.0)),
                "y": uplot.Scale(auto=True),
            },
            axes=_axes(""),
            legend=uplot.Legend(show=True, live=False),
            height=HEIGHT,
        )

    def add(self, time: float, residuals: Residuals | None) -> None:
        """Remember one sample; None where there is none that is fresh and valid."""
        values = np.full(len(self._options), np.nan)
        thresholds = np.full(len(self._options), np.nan)
        if residuals is not None:
            n = self._joints
            values[:n], thresholds[:n] = _joint_residual(residuals)
            if residuals.valid_external:
                values[n:], thresholds[n:] = residuals.external, residuals.threshold_external
        self._residuals.add(time, values)
        self._thresholds.add(time, thresholds)

    def clear(self) -> None:
        """Forget what was."""
        self._residuals.clear()
        self._thresholds.clear()

    def draw(self) -> None:
        """Send the chosen residual to the browsers, from its first value on.

        A chart that begins with a gap draws nothing.
        """
        index = self._options.index(self._choice.value)
        ages, values = self._residuals.column(index)
        shown = np.maximum.accumulate(np.isfinite(values))
        if shown.sum() < 2:
            return
        threshold = self._thresholds.column(index)[1]
        self._plot.data = ages[shown], values[shown], threshold[shown], -threshold[shown]
        self._label("N m" if index < self._joints or self._choice.value[-2] == "m" else "N")

    def _label(self, unit: str) -> None:
        if unit != self._unit:
            self._unit = unit
            self._plot.axes = _axes(unit)


def _joint_residual(residuals: Residuals) -> tuple[Array | float, Array | float]:
    if residuals.valid_internal:
        return residuals.internal, residuals.threshold_internal
    if residuals.valid_classical and residuals.classical is not None:
        return residuals.classical, residuals.threshold_internal
    return np.nan, np.nan


def _series(name: str) -> tuple[uplot.Series, ...]:
    edge = uplot.Series(label="threshold", stroke="#f85149", width=1.0, dash=(5, 4))
    return (
        uplot.Series(label="t"),
        uplot.Series(label=name, stroke="#f07828", width=2.0),
        edge,
        uplot.Series(**{**edge, "label": "-threshold"}),
    )


def _axes(unit: str) -> tuple[uplot.Axis, ...]:
    look = {"stroke": TEXT, "grid": {"stroke": LINES, "width": 1}, "font": "11px system-ui"}
    return (
        uplot.Axis(label="time [s]", labelSize=18, size=26, **look),
        uplot.Axis(label=f"[{unit}]", labelSize=18, size=40, **look),
    )
