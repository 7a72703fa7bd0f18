"""The picture of an Enhanced Oriented Graph, in the manner of the thesis of Fumagalli."""

from collections.abc import Mapping, Sequence

from deploy.graph_picture.layout import Node, Shape, lay_out
from deploy.graph_picture.legend import legend
from deploy.graph_picture.shapes import (
    RADIUS,
    SYMBOL,
    Point,
    arrow,
    color,
    symbol,
    text,
    towards,
)
from deploy.graph_picture.view import View
from estimation.graph.enhanced_graph import EnhancedGraph

COLUMN, ROW, MARGIN = 118.0, 52.0, 50.0  # px
LETTER = 5.5  # px, mean width of a letter in a label
STYLE = (
    "<style>svg{font-family:sans-serif}"
    "polyline{fill:none;stroke:#555;stroke-width:1.2}"
    "circle,polygon{stroke:#222;stroke-width:1.2}"
    "text{paint-order:stroke;stroke:white;stroke-width:3px}"
    ".link{font-size:10px;fill:#222}.edge{font-size:9px;fill:#666}"
    ".leaf{font-size:10px;fill:#222;font-style:italic}.legend{font-size:11px;fill:#222}</style>"
)
HEAD = (
    '<defs><marker id="head" viewBox="0 0 8 8" refX="8" refY="4" markerWidth="7" markerHeight="7"'
    ' orient="auto"><path d="M0,0 L8,4 L0,8 z" fill="#555"/></marker></defs>'
)


def graph_svg(
    graph: EnhancedGraph,
    root: str,
    names: Sequence[str],
    notes: Mapping[str, str] | None = None,
    view: View = View.all,
) -> str:
    """Return the picture as the text of an SVG file, the same for the same graph.

    Args:
        graph: The graph.
        root: Link at the left end.
        names: Of the sub-graphs.
        notes: What is added to the label of a leaf, by its name.
        view: Which symbols are shown; the kinematic graph is not cut.
    """
    tree = lay_out(graph, root, view)
    nodes = list(tree.below())
    width = max(_right_end(node, notes or {}) for node in nodes) + MARGIN
    below = max(_at(node)[1] for node in nodes) + MARGIN
    key, height = legend(_shapes(nodes), names, below, width)
    lines = [line for node in nodes for child in node.children for line in _line(node, child)]
    symbols = [symbol(node.shape, _at(node), color(node.subgraph)) for node in nodes]
    labels = [label for node in nodes for label in _labels(node, notes or {})]
    elements = [*lines, *symbols, *labels, *key]
    return "\n".join([*_opening(width, height), *elements, "</svg>", ""])


def _opening(width: float, height: float) -> list[str]:
    return [
        f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {width:.0f} {height:.0f}"'
        f' width="{width:.0f}" height="{height:.0f}">',
        STYLE,
        HEAD,
        f'<rect width="{width:.0f}" height="{height:.0f}" fill="white"/>',
    ]


def _at(node: Node) -> Point:
    return MARGIN + COLUMN * node.column, MARGIN + ROW * node.row


def _shapes(nodes: Sequence[Node]) -> set[Shape]:
    shapes = {node.shape for node in nodes}
    return shapes | {Shape.known} if Shape.sublink in shapes else shapes


def _right_end(node: Node, notes: Mapping[str, str]) -> float:
    x = _at(node)[0]
    if node.shape in (Shape.link, Shape.sublink):
        return x + LETTER * len(node.label) / 2.0
    return x + 1.5 * SYMBOL + LETTER * len(_words(node, notes))


def _words(node: Node, notes: Mapping[str, str]) -> str:
    return " ".join(filter(None, (node.label, notes.get(node.label, ""))))


def _line(near: Node, far: Node) -> list[str]:
    """Return what joins two nodes, with its heads."""
    start, end = _at(near), _at(far)
    bend = start[0] + 0.22 * COLUMN, end[1]
    points = [towards(start, bend, RADIUS), bend, (end[0] - _size(far), end[1])]
    if far.via is None:
        inwards = far.shape in (Shape.known, Shape.unknown)
        return [arrow(points[::-1] if inwards else points)]
    if far.via.kind == "sensor" and far.shape is Shape.sublink:
        return _cut(points)
    return [arrow(points if far.via.head == far.label else points[::-1])]


def _size(node: Node) -> float:
    return RADIUS if node.shape in (Shape.link, Shape.sublink) else SYMBOL


def _cut(points: list[Point]) -> list[str]:
    """Return a force/torque sensor: a known wrench on each of its two sub-links."""
    start, bend, end = points
    near, far = _cut_rhombi(bend, end)
    return [
        arrow([(near[0] - SYMBOL, near[1]), bend, start]),
        arrow([(far[0] + SYMBOL, far[1]), end]),
        symbol(Shape.known, near, ""),
        symbol(Shape.known, far, ""),
    ]


def _cut_rhombi(bend: Point, end: Point) -> tuple[Point, Point]:
    middle = (bend[0] + end[0]) / 2.0
    return (middle - 1.3 * SYMBOL, end[1]), (middle + 1.3 * SYMBOL, end[1])


def _labels(node: Node, notes: Mapping[str, str]) -> list[str]:
    x, y = _at(node)
    if node.shape not in (Shape.link, Shape.sublink):
        return [text(_words(node, notes), (x + 1.5 * SYMBOL, y + 4.0), "leaf", "start")]
    labels = [text(node.label, (x, y + RADIUS + 11.0), "link")]
    if node.via is not None:
        middle = x - 0.39 * COLUMN - RADIUS / 2.0
        labels.append(text(node.via.name, (middle, y - SYMBOL - 3.0), "edge"))
    return labels
