"""Signed bars of the joint torques, as one piece of HTML."""

import numpy as np

from .html import escape

Array = np.ndarray

FULL = "#f07828"  # the page's colour of an estimate
TRUE = "#4aa3ff"  # and of truth
OVER = "#f85149"


def torque_bars(
    joints: tuple[str, ...],
    torque: Array,
    valid: Array,
    limit: Array,
    truth: Array | None = None,
) -> str:
    """Return a table with one signed bar per joint in two columns.

    Args:
        joints: Names, (n,).
        torque: Link torques, (n,) [N m].
        valid: Which of them are valid, (n,).
        limit: Torque limits, positive, (n,) [N m]; the bar's end.
        truth: True link torques, (n,) [N m], marked by a blue tick.
    """
    fraction = np.clip(torque / limit, -1.0, 1.0)
    marks = [None] * len(joints) if truth is None else np.clip(truth / limit, -1.0, 1.0)
    cells = list(map(_cell, joints, torque, fraction, valid, limit, marks))
    half = (len(cells) + 1) // 2
    columns = "".join(
        f'<div style="flex:1;min-width:0">{"".join(part)}</div>'
        for part in (cells[:half], cells[half:])
    )
    return (
        '<div id="torques" style="display:flex;gap:10px;padding:0 12px;'
        f'font:10.5px/14px system-ui,sans-serif">{columns}</div>'
    )


def _cell(
    joint: str, torque: float, fraction: float, valid: bool, limit: float, mark: float | None
) -> str:
    colour = OVER if abs(fraction) >= 1.0 else FULL
    value = f"{torque:+.1f}" if valid else "--"
    bar = _bar(fraction, colour) if valid else ""
    tick = "" if mark is None else _tick(mark)
    return (
        f'<div title="{escape(joint)}: limit {limit:.0f} N m" style="display:flex;gap:4px">'
        f'<span style="width:86px;overflow:hidden;white-space:nowrap;text-overflow:ellipsis">'
        f"{escape(joint)}</span>"
        '<span style="position:relative;flex:1;min-width:30px;background:#8884;margin:2px 0;'
        f'border-left:1px solid #888;border-right:1px solid #888">{_zero()}{bar}{tick}</span>'
        f'<span style="width:34px;text-align:right">{value}</span></div>'
    )


def _zero() -> str:
    return '<i style="position:absolute;left:50%;top:0;bottom:0;width:1px;background:#aaa"></i>'


def _bar(fraction: float, colour: str) -> str:
    left = 50.0 + 50.0 * min(fraction, 0.0)
    return (
        f'<i style="position:absolute;left:{left:.1f}%;width:{50.0 * abs(fraction):.1f}%;'
        f'top:0;bottom:0;background:{colour}"></i>'
    )


def _tick(fraction: float) -> str:
    left = 50.0 + 50.0 * fraction
    return (
        f'<i style="position:absolute;left:calc({left:.1f}% - 1px);width:2px;top:-2px;bottom:-2px;'
        f'background:{TRUE}"></i>'
    )
