"""The demo as a process, found by nobody but the benchmark."""

import json
import os
import signal
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

from bus import Node


@dataclass(frozen=True)
class RunningDemo:
    """A demo whose services are all ready."""

    node: Node  # a place on its bus
    pids: dict[str, int]  # by service, the launcher's included
    ready_after: float  # [s] from the start until all services were ready


NO_SCREEN = {"DISPLAY": "", "WAYLAND_DISPLAY": ""}


@contextmanager
def running_demo(*flags: str) -> Iterator[RunningDemo]:
    """Run ``wrenchbus demo`` with some flags, without a screen; it ends with the block."""
    with tempfile.TemporaryDirectory() as folder:
        start = time.monotonic()
        with subprocess.Popen(
            [sys.executable, "-m", "deploy.main", "demo", *flags],
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            env={**os.environ, **NO_SCREEN, "XDG_RUNTIME_DIR": folder},
        ) as process:
            try:
                _await_first_line(process)
                ready_after = time.monotonic() - start
                with _join(folder) as node:
                    rows = node.call("/launcher/rpc:i", "status")
                    pids = {row["service"]: row["pid"] for row in rows}
                    yield RunningDemo(node, {"launcher": process.pid} | pids, ready_after)
            finally:
                process.send_signal(signal.SIGINT)


def _await_first_line(process: subprocess.Popen[bytes]) -> None:
    """Wait for what the demo prints when everything is ready."""
    assert process.stdout is not None
    if not process.stdout.readline():
        raise RuntimeError(f"the demo did not start: exit status {process.wait()}")


def _join(folder: str) -> Node:
    [entry] = Path(folder, "wrenchbus").glob("*.json")
    found = json.loads(entry.read_text())
    return Node("benchmark", connect=found["endpoint"], namespace=found["namespace"], signals=False)
