"""The recorder as a process: idle until it is asked to start."""

import os
import time
from pathlib import Path
from typing import Any

from bus import Node
from services.recorder.config import RecorderConfig
from services.recorder.session import STEP, RecordingSession

IDLE = 0.5  # s; a request ends the wait
SUFFIX = ".mcap"


def main(node: Node, config: RecorderConfig) -> None:
    """Record when asked, until asked to end."""
    service = RecorderService(node)
    node.ready()
    try:
        while node.running:
            node.wait(STEP if service.recording else IDLE)
            service.step()
    finally:
        service.stop_if_recording()


class RecorderService:
    """The verbs ``start``, ``stop`` and ``status``, and one recording at a time."""

    def __init__(self, node: Node):
        self._node = node
        self._session: RecordingSession | None = None
        node.verb("start", self.start)
        node.verb("stop", self.stop)
        node.verb("status", self.status, help="whether it records, which file, what was lost")

    @property
    def recording(self) -> bool:
        """Whether a recording is under way."""
        return self._session is not None and self._session.running

    def step(self) -> None:
        """Take in what has come."""
        if self._session is not None:
            self._session.step()

    def start(
        self, file: str = "", ports: list[str] | None = None, everything: bool = False
    ) -> dict[str, Any]:
        """Begin a recording: a file's name in the folder, ports (none: all)."""
        if self.recording:
            raise ValueError(f"recording {self._told()['file']} already")
        config: RecorderConfig = self._node.parameters.value
        path = _folder(config) / _name(file, config)
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
        except OSError as error:
            raise ValueError(f"{path.parent}: {error.strerror}") from None
        self._session = RecordingSession(self._node, path, config, ports or (), everything)
        return self._told()

    def stop(self) -> dict[str, Any]:
        """Finish the recording; tell what it holds."""
        if not self.recording:
            raise ValueError("nothing is being recorded")
        self.stop_if_recording()
        return self._told()

    def stop_if_recording(self) -> None:
        """Finish the recording if there is one."""
        if self._session is not None:
            self._session.stop()

    def status(self) -> dict[str, Any]:
        """Return the state of the service, and of its present or last recording."""
        return {**self._node.status(), **self._told()}

    def _told(self) -> dict[str, Any]:
        return {"recording": False} if self._session is None else self._session.status()


def _folder(config: RecorderConfig) -> Path:
    if config.folder:
        return Path(config.folder).expanduser()
    home = os.environ.get("XDG_DATA_HOME") or Path.home() / ".local" / "share"
    return Path(home) / "wrenchbus"


def _name(file: str, config: RecorderConfig) -> str:
    """Return the name of the file; whoever asks chooses no other folder."""
    if not file:
        return f"{Path(config.robot).stem}-{time.strftime('%Y%m%d-%H%M%S')}{SUFFIX}"
    if Path(file).name != file or file.startswith("."):
        raise ValueError(f"file: expected a plain name such as walk.mcap, got {file!r:.80}")
    return file if file.endswith(SUFFIX) else file + SUFFIX
