"""Small pieces of HTML. Every text that comes from the bus passes through ``escape``."""

from html import escape as _escape

GREEN, AMBER, RED, GREY = "#3fb950", "#f0a030", "#f85149", "#8b949e"


def escape(text: object) -> str:
    """Return the text with every character that HTML understands made harmless."""
    return _escape(str(text), quote=True)


def line(identifier: str, text: str, colour: str, size: str = "15px") -> str:
    """Return one bold line of text that a test finds by its identifier."""
    return (
        f'<div id="{identifier}" style="font:600 {size}/1.35 system-ui,sans-serif;'
        f'color:{colour};padding:1px 12px;overflow-wrap:anywhere">{escape(text)}</div>'
    )


def note(identifier: str, text: str, colour: str = GREY) -> str:
    """Return one quiet line of text."""
    return (
        f'<div id="{identifier}" style="font:12px/1.4 system-ui,sans-serif;color:{colour};'
        f'padding:1px 12px;overflow-wrap:anywhere">{escape(text)}</div>'
    )
