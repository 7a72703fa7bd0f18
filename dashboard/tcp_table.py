"""The machine's TCP sockets (Linux; elsewhere there are none to be seen)."""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

LISTEN = "0A"
TABLES = (Path("/proc/net/tcp"), Path("/proc/net/tcp6"))


class Socket(NamedTuple):
    """A row of the kernel's table."""

    state: str  # hexadecimal
    remote: str
    inode: str


def sockets(port: int) -> Iterator[Socket]:
    """Yield the sockets of a local port."""
    end = f":{port:04X}"
    for table in TABLES:
        text = table.read_text() if table.exists() else ""
        for row in map(str.split, text.splitlines()[1:]):
            if row[1].endswith(end):
                yield Socket(state=row[3], remote=row[2], inode=row[9])
