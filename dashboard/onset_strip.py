"""Which limb was touched when: the last minute, as bars, and the flags of now."""

from typing import Any

import numpy as np

from robot_model.messages import Contacts

from .history import History
from .html import AMBER, GREEN, GREY, RED, escape

Array = np.ndarray

SPAN = 60.0  # [s] of the session's clock
PERIOD = 0.2  # [s] of one column
GAP = 2.0  # [s] longer ones are drawn as such: nobody looked
LEVELS = {"none": 0.0, "contact": 1.0, "collision": 2.0}
COLOURS = {"none": GREEN, "contact": AMBER, "collision": RED}
BODY = "whole body"
NOTE = f"last {SPAN:.0f} s; at the right the statistic and its threshold [standard deviations]"


class OnsetStrip:
    """Remembers the flags of all limbs; between two columns the highest counts."""

    def __init__(self, limbs: tuple[str, ...]):
        self._rows = (*limbs, BODY)
        self._history = History(round(SPAN / PERIOD), len(self._rows))
        self._column = np.full(len(self._rows), np.nan)
        self._begun: float | None = None  # [s] when the column under way began

    def add(self, time: float | None, contacts: Contacts | None) -> None:
        """Take in the flags at a time of the session's clock [s]; None where they are unknown."""
        if time is None:
            return
        self._column = np.fmax(self._column, self._levels(contacts))
        if self._begun is None or not 0.0 <= time - self._begun < PERIOD:
            self._history.add(time, self._column)
            self._column, self._begun = np.full(len(self._rows), np.nan), time

    def bars(self) -> dict[str, list[tuple[float, float, int]]]:
        """Return per row its bars: begin and end as ages [s], negative, and level 0 to 2."""
        return {row: self._bars(i) for i, row in enumerate(self._rows)}

    def html(self, contacts: Contacts | None) -> str:
        """Return the strip as HTML, with the flags of now."""
        flags = _flags(contacts)
        rows = "".join(_row(row, bars, flags.get(row)) for row, bars in self.bars().items())
        return (
            '<div id="strip" style="padding:2px 12px;font:11px/13px system-ui,sans-serif">'
            f'{rows}<div style="color:{GREY}">{NOTE}</div></div>'
        )

    def _levels(self, contacts: Contacts | None) -> Array:
        flags = _flags(contacts)
        return np.array([_level(flags.get(row)) for row in self._rows])

    def _bars(self, index: int) -> list[tuple[float, float, int]]:
        ages, levels = self._history.column(index)
        known = np.flatnonzero(np.isfinite(levels) & (ages > -SPAN))
        bars: list[tuple[float, float, int]] = []
        for i in known:
            before = ages[i - 1] if i else ages[i] - PERIOD
            begin = max(before, ages[i] - GAP, -SPAN)
            if bars and bars[-1][2] == levels[i] and bars[-1][1] >= begin:
                bars[-1] = bars[-1][0], ages[i], bars[-1][2]
            else:
                bars.append((begin, ages[i], int(levels[i])))
        return bars


def _flags(contacts: Contacts | None) -> dict[str, dict[str, Any]]:
    if contacts is None:
        return {}
    flags = {flag["limb"]: flag for flag in contacts.flags}
    return flags | ({BODY: contacts.body} if contacts.body else {})


def _level(flag: dict[str, Any] | None) -> float:
    return np.nan if flag is None or not flag.get("valid", True) else LEVELS[flag["state"]]


def _row(name: str, bars: list[tuple[float, float, int]], flag: dict[str, Any] | None) -> str:
    drawn = "".join(_bar(*bar) for bar in bars)
    return (
        '<div style="display:flex;gap:6px">'
        f'<span style="width:68px;white-space:nowrap">{escape(name)}</span>'
        f'<span style="position:relative;flex:1;background:#8882;margin:2px 0">{drawn}</span>'
        f'<span style="width:120px;text-align:right;white-space:nowrap">{_words(flag)}</span></div>'
    )


def _bar(begin: float, end: float, level: int) -> str:
    colour = ("#3fb95055", AMBER, RED)[level]
    left, width = 100.0 * (1.0 + begin / SPAN), 100.0 * (end - begin) / SPAN
    return (
        f'<i style="position:absolute;left:{left:.1f}%;width:{width:.2f}%;'
        f'top:0;bottom:0;background:{colour}"></i>'
    )


def _words(flag: dict[str, Any] | None) -> str:
    if flag is None:
        return f'<span style="color:{GREY}">unknown</span>'
    if not flag.get("valid", True):
        why = escape(flag.get("reason", ""))
        return f'<span style="color:{GREY}" title="{why}">not judged</span>'
    state = f'<b style="color:{COLOURS[flag["state"]]}">{escape(flag["state"])}</b>'
    if "statistic" not in flag:
        return f"{state} p={flag['probability']:.2f}"
    return f"{state} {flag['statistic']:.1f} / {flag['threshold']:.1f}"
