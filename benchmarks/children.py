"""Processes of a benchmark, which end with it."""

import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from queue import Empty, SimpleQueue
from threading import Thread
from typing import Any

import psutil

from bus.child import command

PATIENCE = 180.0  # s
REPORT = 0.5  # s between reports


class Child:
    """A module of ours as a process, which tells what it has to say in lines of JSON."""

    def __init__(self, module: str, *arguments: str, priority: str = "0"):
        self._name = " ".join((module, *arguments))
        run = command(module, *arguments, priority=priority)
        self.popen = subprocess.Popen(run, stdout=subprocess.PIPE)
        self.pid = self.popen.pid
        self._told: SimpleQueue[str | None] = SimpleQueue()
        Thread(target=self._listen, daemon=True).start()

    def told(self) -> Any:
        """Return what the process tells next; the first time, that it is ready."""
        line = self._told.get(timeout=PATIENCE)
        if line is None:
            raise RuntimeError(f"{self._name} ended with {self.popen.wait()}")
        return json.loads(line)

    def all_told(self) -> list[Any]:
        """Return all that the process has told by now."""
        lines = []
        try:
            while (line := self._told.get_nowait()) is not None:
                lines.append(json.loads(line))
        except Empty:
            pass
        return lines

    def _listen(self) -> None:
        assert self.popen.stdout is not None
        for line in self.popen.stdout:
            self._told.put(line.decode())
        self._told.put(None)

    def kill(self) -> None:
        """Kill the process, as a crash would; may be called again."""
        self.popen.kill()
        self.popen.wait()


def own_memory(pid: int | None = None) -> int:
    """Return the bytes of memory that a process (None: this one) shares with nobody."""
    return psutil.Process(pid).memory_full_info().uss


def tell(what: Any) -> None:
    """Tell the benchmark something, in one of its processes."""
    print(json.dumps(what), flush=True)


class Reporter:
    """Tells twice per second what a process has counted since it told last.

    Nothing is asked for by RPC: a process that cannot keep up may not get to answering.
    """

    def __init__(self, report: Callable[[], dict[str, Any]]):
        sys.setswitchinterval(1e-3)  # as all our services do
        self._report, self._due = report, time.monotonic() + REPORT

    def tell(self) -> None:
        """Tell, if it is time."""
        now = time.monotonic()
        if now >= self._due:
            self._due = now + REPORT
            tell(self._report() | {"time": now})


@contextmanager
def child(module: str, *arguments: str, priority: str = "0") -> Iterator[Child]:
    """Run a module until the end of the block; it may not have told that it is ready."""
    process = Child(module, *arguments, priority=priority)
    try:
        yield process
    finally:
        process.kill()


@contextmanager
def hub_process() -> Iterator[tuple[str, int]]:
    """Run a hub that is found by nobody else; return its endpoint and its process number."""
    from bus.testing import start_hub  # pytest is not for the other processes

    endpoint, process = start_hub()
    try:
        yield endpoint, process.pid
    finally:
        process.clean_up()
