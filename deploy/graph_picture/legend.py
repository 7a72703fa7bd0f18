"""What the symbols and colours of a graph's picture mean."""

from collections.abc import Collection, Sequence

from deploy.graph_picture.layout import Shape
from deploy.graph_picture.shapes import SYMBOL, color, symbol, text

ROW, ENTRY, LEFT = 24.0, 200.0, 30.0  # px


def legend(
    shapes: Collection[Shape], names: Sequence[str], top: float, width: float
) -> tuple[list[str], float]:
    """Return the elements of a legend below ``top`` px, and its lower end."""
    entries = [(shape, shape.value, "white") for shape in Shape if shape in shapes]
    elements, bottom = _rows(entries, top, width)
    subgraphs = [(Shape.link, name, color(i)) for i, name in enumerate(names)]
    more, bottom = _rows(subgraphs, bottom, width)
    return elements + more, bottom


def _rows(
    entries: Sequence[tuple[Shape, str, str]], top: float, width: float
) -> tuple[list[str], float]:
    """Lay entries side by side, in as many rows as they need."""
    fitting = max(1, int((width - LEFT) // ENTRY))
    elements = []
    for i, (shape, words, fill) in enumerate(entries):
        x, y = LEFT + ENTRY * (i % fitting), top + ROW * (i // fitting)
        elements.append(symbol(shape, (x, y), fill))
        elements.append(text(words, (x + 2.0 * SYMBOL, y + 4.0), "legend", "start"))
    return elements, top + ROW * -(-len(entries) // fitting)
