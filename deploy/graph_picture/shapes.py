"""Shapes of a graph's picture, as SVG elements; lengths in pixels."""

from html import escape
from math import hypot

from deploy.graph_picture.layout import Shape

Point = tuple[float, float]

RADIUS = 9.0
SYMBOL = 8.0
# Of well distinguishable brightness and hue; sub-graphs beyond the last begin anew.
COLORS = (
    "#9ecae9", "#ffbf79", "#88d27a", "#ff9d98", "#d4a6c8",
    "#f2cf5b", "#83bcb6", "#d8b5a5", "#bab0ac", "#b6a0e0",
)  # fmt: skip
FILLED = {Shape.inertial, Shape.known}


def color(subgraph: int) -> str:
    """Return the colour of a sub-graph."""
    return COLORS[subgraph % len(COLORS)]


def symbol(shape: Shape, at: Point, fill: str) -> str:
    """Return a node; black and white symbols as in Figure 3.6 of the thesis."""
    x, y = at
    if shape in (Shape.link, Shape.sublink):
        dash = ' stroke-dasharray="3 2"' if shape is Shape.sublink else ""
        return f'<circle cx="{x:.1f}" cy="{y:.1f}" r="{RADIUS:g}" fill="{fill}"{dash}/>'
    inside = "#222" if shape in FILLED else "white"
    triangle = shape in (Shape.inertial, Shape.motion)
    return _polygon(_triangle(at) if triangle else rhombus(at), inside)


def _triangle(at: Point) -> list[Point]:
    x, y = at
    return [(x - SYMBOL, y - SYMBOL * 0.8), (x + SYMBOL, y - SYMBOL * 0.8), (x, y + SYMBOL)]


def rhombus(at: Point) -> list[Point]:
    """Return the corners of a rhombus."""
    x, y = at
    return [(x - SYMBOL, y), (x, y - SYMBOL), (x + SYMBOL, y), (x, y + SYMBOL)]


def _polygon(points: list[Point], fill: str) -> str:
    return f'<polygon points="{_listed(points)}" fill="{fill}"/>'


def arrow(points: list[Point]) -> str:
    """Return a line through points with its head at the last one."""
    return f'<polyline points="{_listed(points)}" marker-end="url(#head)"/>'


def _listed(points: list[Point]) -> str:
    return " ".join(f"{x:.1f},{y:.1f}" for x, y in points)


def towards(start: Point, end: Point, distance: float) -> Point:
    """Return the point at a distance from ``start`` on the way to ``end``."""
    length = hypot(end[0] - start[0], end[1] - start[1])
    share = distance / length if length else 0.0
    return start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])


def text(words: str, at: Point, kind: str, anchor: str = "middle") -> str:
    """Return a text; ``kind`` is its class in the picture's style."""
    place = f'x="{at[0]:.1f}" y="{at[1]:.1f}"'
    return f'<text {place} class="{kind}" text-anchor="{anchor}">{escape(words)}</text>'
