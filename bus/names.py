"""Port names, and how they become Zenoh keys."""

import re
from collections.abc import Iterable
from difflib import get_close_matches
from typing import Literal
from urllib.parse import quote, unquote

from bus.errors import BusError

StreamKind = Literal["whole", "thinned", "bundled"]

_NAME = re.compile(r"(/[A-Za-z0-9_.:-]+)+")
_EMPTY = "%"  # never produced by quoting, and Zenoh allows no empty chunk


def check_name(name: str, direction: str = "") -> str:
    """Return a port's name, or raise when it breaks the rules (and the suffix of its direction)."""
    if not _NAME.fullmatch(name):
        raise BusError(
            f"bad port name {name!r}: expected chunks of letters, digits and _.:- that each begin"
            " with a slash, as in /icub/sensors:o"
        )
    suffix = {"output": ":o", "input": ":i", "rpc": ":i"}.get(direction, "")
    if not name.endswith(suffix):
        raise BusError(f"bad port name {name!r}: the name of an {direction} port ends in {suffix}")
    return name


def key_of(name: str) -> str:
    """Return the Zenoh key of a port: its name without the leading slash."""
    return check_name(name)[1:]


def stream_key(name: str, stream: StreamKind) -> str:
    """Return the Zenoh key of one of an output's streams."""
    return key_of(name) if stream == "whole" else f"@wb/{stream}/{key_of(name)}"


def to_chunk(text: str) -> str:
    """Quote any text so that it is one chunk of a Zenoh key."""
    return quote(text, safe="") or _EMPTY


def from_chunk(chunk: str) -> str:
    """Undo `to_chunk`."""
    if "%" not in chunk:
        return chunk
    return "" if chunk == _EMPTY else unquote(chunk)


def near_names(name: str, existing: Iterable[str], count: int = 3) -> list[str]:
    """Return the existing names most like `name`, best first."""
    return get_close_matches(name, list(existing), n=count, cutoff=0.5)


def did_you_mean(name: str, existing: Iterable[str]) -> str:
    """Return `` (did you mean a, b?)`` or nothing, to be appended to an error."""
    near = near_names(name, existing)
    return f" (did you mean {', '.join(near)}?)" if near else ""
