"""One service as a child process: started, watched, started again, stopped."""

import os
import signal
import subprocess
import time
from typing import Any

from bus.child import command
from deploy.launcher.logs import Log
from deploy.launcher.parts import Restart
from deploy.one_thread import ONE_THREAD

FIRST_BACKOFF = 0.5  # [s], doubles with every death
LONGEST_BACKOFF = 8.0  # [s]
SETTLED = 10.0  # [s] of life after which the back-off starts anew
WRONG_USAGE = 2  # exit status: the same settings would fail again


class Process:
    """A child process and what the launcher knows about it.

    ``state`` is starting, ready, waiting (to be started again), stopped or failed.
    """

    def __init__(
        self,
        name: str,
        arguments: list[str],
        log: Log,
        priority: str = "0",
        restart: Restart = "always",
    ):
        self.name = name
        self.arguments = arguments
        self.priority = priority  # niceness, or "realtime"
        self.restart = restart
        self.state = "stopped"
        self.restarts = 0
        self._log = log
        self._child: subprocess.Popen[bytes] | None = None
        self._started = 0.0
        self._backoff = FIRST_BACKOFF
        self._start_again = 0.0

    @property
    def pid(self) -> int | None:
        """Process number while it runs."""
        return self._child.pid if self._child and self.alive else None

    @property
    def alive(self) -> bool:
        """Whether the child has not ended."""
        return self._child is not None and self._child.poll() is None

    def start(self) -> None:
        """Start the child; what it prints goes to the log under its name."""
        self._child = subprocess.Popen(
            command(*self.arguments, priority=self.priority),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.STDOUT,
            start_new_session=True,  # Ctrl-C reaches the launcher only, which stops all in order
            env={**os.environ, **ONE_THREAD, "PYTHONUNBUFFERED": "1"},
        )
        self._log.follow(self.name, self._child.stdout)
        self._started = time.monotonic()
        self.state = "starting"

    def supervise(self) -> None:
        """Notice a death and start again when the back-off is over."""
        if self.state in ("starting", "ready") and not self.alive:
            self._died()
        elif self.state == "waiting" and time.monotonic() >= self._start_again:
            self.restarts += 1
            self.start()

    def _died(self) -> None:
        code = self._child.returncode if self._child else 0
        if code == WRONG_USAGE:
            self.state = "failed"
            self._log.say(self.name, "wrong settings (exit status 2): not started again")
        elif self.restart == "never" or (self.restart == "on-failure" and code == 0):
            self.state = "stopped"
            self._log.say(self.name, f"ended ({_cause(code)})")
        else:
            self._wait_to_restart(code)

    def _wait_to_restart(self, code: int) -> None:
        now = time.monotonic()
        if now - self._started > SETTLED:
            self._backoff = FIRST_BACKOFF
        self._start_again = now + self._backoff
        self._log.say(self.name, f"died ({_cause(code)}), starts again in {self._backoff:g} s")
        self._backoff = min(2.0 * self._backoff, LONGEST_BACKOFF)
        self.state = "waiting"

    def status(self) -> dict[str, Any]:
        """Return what ``wrenchbus status`` shows."""
        return {
            "service": self.name,
            "pid": self.pid,
            "state": self.state,
            "ready": self.state == "ready",
            "restarts": self.restarts,
            "uptime_s": round(time.monotonic() - self._started, 3) if self.alive else 0.0,
        }

    def send(self, number: signal.Signals) -> None:
        """Send a signal, if there is anybody to receive it."""
        if self._child and self.alive:
            self._child.send_signal(number)

    def reap(self) -> None:
        """Collect the ended child."""
        if self._child:
            self._child.wait()
        self.state = "stopped" if self.state != "failed" else self.state


def stop_all(processes: list[Process], grace: float) -> None:
    """End processes by SIGTERM, and after ``grace`` [s] by SIGKILL."""
    for process in processes:
        process.send(signal.SIGTERM)
    deadline = time.monotonic() + grace
    while time.monotonic() < deadline and any(process.alive for process in processes):
        time.sleep(0.01)
    for process in processes:
        process.send(signal.SIGKILL)
        process.reap()


def _cause(code: int) -> str:
    if code >= 0:
        return f"exit status {code}"
    return signal.Signals(-code).name
