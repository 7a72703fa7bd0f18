"""Who holds a TCP port of this machine (Linux; elsewhere nobody is named)."""

import contextlib
import errno
import os
import socket
from pathlib import Path

LISTEN = "0A"


class PortBusyError(OSError):
    """The page's port is taken."""


def require_free(host: str, port: int) -> None:
    """Raise PortBusyError, which names who holds it, unless the port can be bound."""
    with socket.socket(_family(host)) as probe:
        probe.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        try:
            probe.bind((host, port))
        except OSError as error:
            if error.errno != errno.EADDRINUSE:
                raise
            raise PortBusyError(
                f"port {port} of {host} is taken by {holder(port)}; expected a free one:"
                " give another port, or 0 to let the system choose"
            ) from None


def holder(port: int) -> str:
    """Return ``pid N (command)`` of the process that listens on the port, as far as readable."""
    inodes = {f"socket:[{inode}]" for inode in _listening(port)}
    for process in Path("/proc").glob("[0-9]*"):
        if inodes & _open_files(process):
            return f"pid {process.name} ({_command(process)})"
    return "another process"


def _family(host: str) -> socket.AddressFamily:
    return socket.AF_INET6 if ":" in host else socket.AF_INET


def _listening(port: int) -> list[str]:
    """Inodes of the sockets that listen on the port: column 9 of /proc/net/tcp."""
    inodes = []
    for table in (Path("/proc/net/tcp"), Path("/proc/net/tcp6")):
        rows = table.read_text().splitlines()[1:] if table.exists() else []
        for row in map(str.split, rows):
            if row[3] == LISTEN and int(row[1].rpartition(":")[2], 16) == port:
                inodes.append(row[9])
    return inodes


def _open_files(process: Path) -> set[str]:
    """Targets of a process's descriptors, as far as they can be read."""
    targets = set()
    with contextlib.suppress(OSError):  # the process ended, or belongs to somebody else
        for file in (process / "fd").iterdir():
            with contextlib.suppress(FileNotFoundError):  # closed meanwhile
                targets.add(os.readlink(file))
    return targets


def _command(process: Path) -> str:
    try:
        words = (process / "cmdline").read_bytes().split(b"\0")
    except OSError:
        return "unknown"
    return b" ".join(words).decode(errors="replace").strip() or "unknown"
