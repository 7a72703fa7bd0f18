"""Figures of lines over time as SVG, the same bytes for the same numbers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from experiments.svg import svg

if TYPE_CHECKING:
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

Array = np.ndarray
POINTS = 400  # of a line, at most
WIDTH, HEIGHT = 4.2, 1.8  # inch, of a panel
TOP, BOTTOM = 0.7, 0.45  # inch, around the panels
STROKES = (("#1f77b4", "-"), ("#d95f02", "--"), ("#555555", ":"))


@dataclass(frozen=True, eq=False)
class Panel:
    """One plot; all its lines have the figure's times."""

    title: str  # with its unit
    lines: Mapping[str, Array]  # (T,) by label


def figure_svg(title: str, time: Array, panels: Sequence[Panel], columns: int = 2) -> str:
    """Return a figure of panels, row by row; ``time`` (T,) in seconds."""
    return svg(lambda: _figure(title, time, panels, columns))


def _figure(title: str, time: Array, panels: Sequence[Panel], columns: int) -> "Figure":
    from matplotlib.figure import Figure

    rows = -(-len(panels) // columns)
    size = columns * WIDTH, rows * HEIGHT + TOP + BOTTOM
    figure = Figure(size)
    figure.subplots_adjust(
        left=0.9 / size[0],
        right=1.0 - 0.1 / size[0],
        wspace=0.28,
        bottom=BOTTOM / size[1],
        top=1.0 - TOP / size[1],
        hspace=0.28,
    )
    keep = slice(None, None, max(1, -(-len(time) // POINTS)))
    for i, panel in enumerate(panels):
        axes = figure.add_subplot(rows, columns, i + 1)
        _draw(axes, panel, time, keep)
        if i + columns >= len(panels):
            axes.set_xlabel("time [s]")
    lines = figure.axes[0].get_legend_handles_labels()
    figure.legend(*lines, loc="upper center", ncols=3, title=title, title_fontsize=11.0)
    return figure


def _draw(axes: "Axes", panel: Panel, time: Array, keep: slice) -> None:
    for (label, values), (color, dash) in zip(panel.lines.items(), STROKES, strict=False):
        axes.plot(time[keep], values[keep], color=color, linestyle=dash, label=label)
    axes.set_ylabel(panel.title)
    axes.margins(x=0.0)
    axes.locator_params(nbins=5)
