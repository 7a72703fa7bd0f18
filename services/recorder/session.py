"""One recording from its start to its end, whether a service or a command makes it."""

import logging
import time
from collections.abc import Collection
from pathlib import Path
from typing import Any

from bus import BusError, Node
from bus.names import check_name
from bus.recording import RecordingWriter
from bus.recording.recorder import Recorder
from services.recorder.about import about
from services.recorder.circumstances import Circumstances
from services.recorder.config import RecorderConfig

logger = logging.getLogger(__name__)

STEP = 0.02  # s between two steps
LOOK = 1.0  # s between two looks at the disk


class RecordingSession:
    """Records into a file until it is stopped, or until the disk is full.

    Args:
        node: Our place on the bus.
        path: The file.
        config: What is left out, how often is flushed, how much disk is spared.
        ports: What to record; empty: all but what is left out.
        everything: Leave nothing out.
        overwrite: Whether a file that exists is replaced.

    Raises:
        BusError: The file exists, or cannot be written; a port's name breaks the rules.
    """

    def __init__(
        self,
        node: Node,
        path: Path,
        config: RecorderConfig,
        ports: Collection[str] = (),
        everything: bool = False,
        overwrite: bool = False,
    ):
        self.path = path
        self.error = self.warning = ""
        self.running = True
        self._config = config
        self._looked = 0.0
        self._seconds = 0.0
        exclude = () if everything else config.exclude
        for name in ports:
            check_name(name)
        try:
            writer = RecordingWriter(path, about(), overwrite, config.flush)
            self._writer, self._recorder = writer, Recorder(node, writer, ports, exclude)
        except FileExistsError:
            raise BusError(f"{path} exists already and is not overwritten") from None
        except OSError as error:
            raise BusError(f"{path}: {error.strerror or error}") from None
        self._circumstances = Circumstances(node, writer)

    def step(self) -> None:
        """Take in what has come; call it every `STEP`."""
        if not self.running:
            return
        try:
            self._recorder.step()
            self._circumstances.step()
            if time.monotonic() - self._looked > LOOK:
                self._look_at_disk()
        except OSError as error:
            self._fail(error)

    def stop(self, error: str = "") -> None:
        """Finish the file."""
        if not self.running:
            return
        self.error = error
        try:
            self._circumstances.close()
            self._recorder.close()
        except OSError as failure:
            self._fail(failure)
        self._end()

    def status(self) -> dict[str, Any]:
        """Return file, size, duration, and of each port what was recorded and lost."""
        losses = self._writer.losses
        return {
            "recording": self.running,
            "file": str(self.path),
            "size": self._writer.size,
            "seconds": round(self._recorder.seconds if self.running else self._seconds, 3),
            "messages": sum(entry.recorded for entry in losses.values()),
            "lost": self._recorder.lost,
            "warning": self.warning,
            "error": self.error,
            "ports": {name: entry.as_map() for name, entry in sorted(losses.items())},
        }

    def _end(self) -> None:
        self.running = False
        self._seconds = self._recorder.seconds
        self._recorder.abandon()
        self._circumstances.abandon()

    def _fail(self, error: OSError) -> None:
        """The file has no end, but all that was flushed."""
        self._end()
        self.error = (
            f"{self.path}: {error.strerror or error}; recording stopped after"
            f" {self._seconds:.0f} s; wrenchbus log repair rescues what was flushed"
        )
        logger.error("%s", self.error)

    def _look_at_disk(self) -> None:
        self._looked = time.monotonic()
        free = self._writer.free
        if free < self._config.least_space:
            self.stop(f"{self.path}: stopped and finished, the disk has {free * 1e-6:.0f} MB left")
            logger.error("%s", self.error)
        elif free < self._config.low_space and not self.warning:
            self.warning = f"the disk of {self.path.parent} has {free * 1e-6:.0f} MB left"
            logger.warning("%s", self.warning)
