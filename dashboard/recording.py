"""What the page says of the recorder."""

from pathlib import PurePath
from typing import Any

from .html import GREEN, GREY, RED, note

BEGIN, END = "Record", "Finish recording"  # of no other button's name a part


def label(recorder: dict[str, Any]) -> str:
    """Return what the button says, given the recorder's status (empty: there is none)."""
    return END if recorder.get("recording") else BEGIN


def line(recorder: dict[str, Any]) -> str:
    """Return the line about the present or last recording; empty before the first."""
    if not recorder.get("file"):
        return note("recording", "")
    colour = GREEN if recorder["recording"] else GREY
    if recorder["lost"] or recorder["error"] or recorder["warning"]:
        colour = RED
    return note("recording", text(recorder), colour)


def text(recorder: dict[str, Any]) -> str:
    """Return name, size, duration, losses, and what is wrong."""
    verb = "recording" if recorder["recording"] else "recorded"
    minutes, seconds = divmod(int(recorder["seconds"]), 60)
    parts = [
        f"{verb} {PurePath(recorder['file']).name}",
        f"{recorder['size'] * 1e-6:.1f} MB",
        f"{minutes}:{seconds:02d}",
        f"{recorder['lost']} lost",
        recorder["warning"],
        recorder["error"],
    ]
    return ", ".join(filter(None, parts))
