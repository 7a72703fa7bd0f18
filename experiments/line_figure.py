"""Figures of lines over time as SVG: small, and the same bytes for the same numbers."""

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from html import escape

import numpy as np

Array = np.ndarray
WIDTH, HEIGHT = 330.0, 130.0  # px, of a panel's plot
LEFT, TOP, GAP = 56.0, 60.0, 46.0  # px around it
COLORS = ("#1f77b4", "#d95f02", "#555555")
DASHES = ("", "5 3", "1 3")
POINTS = 500  # of a line, at most
STYLE = "<style>svg{font:11px sans-serif}path{fill:none;stroke-width:1.2}.axis{stroke:#bbb}</style>"


@dataclass(frozen=True, eq=False)
class Panel:
    """One plot; all its lines have the figure's times."""

    title: str  # with its unit
    lines: Mapping[str, Array]  # (T,) by label


def figure_svg(title: str, time: Array, panels: Sequence[Panel], columns: int = 2) -> str:
    """Return a figure of panels, row by row; ``time`` (T,) in seconds."""
    keep = slice(None, None, max(1, -(-len(time) // POINTS)))
    rows = -(-len(panels) // columns)
    size = columns * (WIDTH + LEFT) + 20.0, TOP + rows * (HEIGHT + GAP)
    body = [_text(size[0] / 2, 16.0, title, "middle"), *_legend(panels[0], size[0])]
    for i, panel in enumerate(panels):
        corner = LEFT + i % columns * (WIDTH + LEFT), TOP + i // columns * (HEIGHT + GAP)
        body += _panel(panel, corner, time[keep], keep)
    head = f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {size[0]:g} {size[1]:g}"'
    return "\n".join([f'{head} width="{size[0]:g}">', STYLE, _ground(size), *body, "</svg>\n"])


def _ground(size: tuple[float, float]) -> str:
    return f'<rect width="{size[0]:g}" height="{size[1]:g}" fill="white"/>'


def _legend(panel: Panel, width: float) -> list[str]:
    elements = []
    start = width / 2 - 80.0 * len(panel.lines)
    for i, label in enumerate(panel.lines):
        x = start + 160.0 * i
        elements += [_path(f"M{x:g},28h24", i), _text(x + 30.0, 32.0, label, "start")]
    return elements


def _panel(panel: Panel, corner: tuple[float, float], time: Array, keep: slice) -> list[str]:
    x, y = corner
    low, high = _range(panel)
    across = x + WIDTH * (time - time[0]) / max(time[-1] - time[0], 1e-9)
    elements = [_text(x, y - 6.0, panel.title, "start")]
    for value in (low, (low + high) / 2, high):
        level = y + HEIGHT * (high - value) / (high - low)
        elements.append(f'<path class="axis" d="M{x:g},{level:.1f}h{WIDTH:g}"/>')
        elements.append(_text(x - 4.0, level + 4.0, f"{value:.3g}", "end"))
    for share in (0.0, 0.5, 1.0):
        seconds = time[0] + share * (time[-1] - time[0])
        elements.append(_text(x + share * WIDTH, y + HEIGHT + 13.0, f"{seconds:.3g} s", "middle"))
    for i, values in enumerate(panel.lines.values()):
        down = y + HEIGHT * (high - values[keep]) / (high - low)
        points = " ".join(f"{a:.1f},{b:.1f}" for a, b in zip(across, down, strict=True))
        elements.append(_path(f"M{points}", i))
    return elements


def _range(panel: Panel) -> tuple[float, float]:
    values = np.concatenate(list(panel.lines.values()))
    low, high = float(values.min()), float(values.max())
    margin = max(0.08 * (high - low), 1e-6)
    return low - margin, high + margin


def _path(points: str, index: int) -> str:
    color, dash = COLORS[index % len(COLORS)], DASHES[index % len(DASHES)]
    style = f' stroke-dasharray="{dash}"' if dash else ""
    return f'<path d="{points}" stroke="{color}"{style}/>'


def _text(x: float, y: float, words: str, anchor: str) -> str:
    return f'<text x="{x:.1f}" y="{y:.1f}" text-anchor="{anchor}">{escape(words)}</text>'
