"""Figures by matplotlib as SVG: one style, and the same bytes for the same numbers."""

import io
from collections.abc import Callable
from typing import TYPE_CHECKING

if TYPE_CHECKING:  # half a second, for those who draw
    from matplotlib.figure import Figure

STYLE = {
    "svg.fonttype": "none",
    "svg.hashsalt": "wrenchbus",
    "savefig.dpi": 90,  # of what is drawn as pixels
    "font.size": 9.0,
    "lines.linewidth": 1.0,
    "axes.spines.top": False,
    "axes.spines.right": False,
    "axes.grid": True,
    "grid.color": "#e5e5e5",
    "legend.frameon": False,
}


def svg(make: Callable[[], "Figure"]) -> str:
    """Return the figure that ``make`` makes, in our style whatever the user's is."""
    from matplotlib import style

    with style.context(STYLE, after_reset=True):
        buffer = io.StringIO()
        make().savefig(buffer, format="svg", metadata={"Date": None, "Creator": None})
        return buffer.getvalue()
