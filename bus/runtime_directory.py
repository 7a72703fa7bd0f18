"""Finding the bus on this machine: one small JSON file per running hub."""

import json
import os
import re
import tempfile
import time
from pathlib import Path
from typing import NamedTuple

from bus.errors import BusError


class Entry(NamedTuple):
    """What is announced by who runs a hub, or services that use one of another machine."""

    endpoint: str
    namespace: str
    pid: int
    dashboard_url: str
    started: float  # wall time [s]
    insecure: bool = False  # whoever started it here allowed links without protection


def directory() -> Path:
    """Return ``$XDG_RUNTIME_DIR/wrenchbus``, or its like in the system's temporary directory."""
    return Path(os.environ.get("XDG_RUNTIME_DIR") or tempfile.gettempdir()) / "wrenchbus"


def announce(
    endpoint: str, namespace: str = "", dashboard_url: str = "", insecure: bool = False
) -> Path:
    """Write this process's entry (a second call replaces it); return its file.

    Raises:
        BusError: It cannot be written.
    """
    entry = Entry(endpoint, namespace, os.getpid(), dashboard_url, time.time(), insecure)
    try:
        return _write(entry, directory())
    except OSError as error:
        raise BusError(
            f"cannot tell others of the bus in {directory()}: {error.strerror};"
            " expected a folder of yours, set XDG_RUNTIME_DIR"
        ) from None


def _write(entry: Entry, folder: Path) -> Path:
    folder.mkdir(mode=0o700, parents=True, exist_ok=True)
    name = re.sub(r"[^A-Za-z0-9]+", "-", entry.endpoint)
    file = folder / f"{entry.pid}-{name}.json"
    temporary = file.with_suffix(".tmp")
    temporary.write_text(json.dumps(entry._asdict()))
    temporary.replace(file)  # a reader sees the old entry or the new one, never half of one
    return file


def remove(file: Path) -> None:
    """Remove an entry written by `announce`."""
    file.unlink(missing_ok=True)


def entries() -> list[Entry]:
    """Return the entries whose process lives, oldest first; unreadable files are ignored."""
    found = [_read(file) for file in directory().glob("*.json")]
    alive = [entry for entry in found if entry is not None and _is_alive(entry.pid)]
    return sorted(alive, key=lambda entry: entry.started)


def find() -> Entry:
    """Return the one live entry; raise when there is none, or when there are several."""
    alive = entries()
    if not alive:
        raise BusError(
            f"no bus is running: nothing in {directory()}; start one (wrenchbus demo, or"
            " python -m bus.hub), or pass --connect ENDPOINT or set WRENCHBUS_CONNECT"
        )
    if len({(entry.endpoint, entry.namespace) for entry in alive}) > 1:
        several = ", ".join(f"{entry.endpoint} (pid {entry.pid})" for entry in alive)
        raise BusError(f"several buses are running: {several}; choose one with --connect ENDPOINT")
    return alive[-1]


def resolve(connect: str | None) -> tuple[str, str]:
    """Return endpoint and namespace: of ``connect``, ``$WRENCHBUS_CONNECT``, or the entry found."""
    endpoint = connect or os.environ.get("WRENCHBUS_CONNECT")
    if endpoint:
        known = [entry for entry in entries() if entry.endpoint == endpoint]
        return endpoint, known[-1].namespace if known else ""
    entry = find()
    return entry.endpoint, entry.namespace


def is_insecure(endpoint: str) -> bool:
    """Whether somebody on this machine runs a part of the bus there, and allowed that."""
    return any(entry.insecure for entry in entries() if entry.endpoint == endpoint)


def _read(file: Path) -> Entry | None:
    try:
        fields = json.loads(file.read_text())
        fields = {"insecure": False, **fields}
        return Entry(**{name: kind(fields[name]) for name, kind in Entry.__annotations__.items()})
    except (OSError, ValueError, TypeError, KeyError):
        return None


def _is_alive(pid: int) -> bool:
    try:
        os.kill(pid, 0)
    except ProcessLookupError:
        return False
    except (PermissionError, OverflowError):
        return True
    return pid > 0
