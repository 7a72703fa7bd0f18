"""Near names, for errors that say what exists."""

from collections.abc import Iterable
from difflib import get_close_matches


def did_you_mean(name: str, existing: Iterable[str]) -> str:
    """Return ``"; did you mean 'x'?"``, or what exists when nothing is near."""
    known = sorted(existing)
    near = get_close_matches(name, known, n=1, cutoff=0.6)
    if near:
        return f"; did you mean '{near[0]}'?"
    shown = ", ".join(known[:12]) + (", ..." if len(known) > 12 else "")
    return f"; there are: {shown}" if known else "; there is none"
