"""The machine's TCP sockets (Linux; elsewhere there are none to be seen)."""

from collections.abc import Iterator
from pathlib import Path
from typing import NamedTuple

LISTEN = "0A"
TABLES = (Path("/proc/net/tcp"), Path("/proc/net/tcp6"))


class Socket(NamedTuple):
    """A row of the kernel's table; addresses as the kernel writes them."""

    local: str
    remote: str
    state: str  # hexadecimal
    inode: str


def sockets() -> Iterator[Socket]:
    """Yield every socket, for a minute also those that were closed."""
    for table in TABLES:
        text = table.read_text() if table.exists() else ""
        for row in map(str.split, text.splitlines()[1:]):
            yield Socket(local=row[1], remote=row[2], state=row[3], inode=row[9])


def is_at(address: str, port: int) -> bool:
    """Whether an address has a port."""
    return address.endswith(f":{port:04X}")
