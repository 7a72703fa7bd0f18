"""A service's log, for everybody on the bus: its last records when asked, new ones as they come."""

import logging
from collections import deque
from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, ClassVar

from bus.envelope import WALL
from bus.errors import BusError

if TYPE_CHECKING:
    from bus.node import Node

RECENT = 200  # records that a service remembers
LONGEST = 4000  # characters of one record
LEVELS = ("debug", "info", "warning", "error", "critical")


@dataclass(frozen=True, kw_only=True)
class LogRecord:
    """One line of a service's log."""

    TYPE: ClassVar[str] = "LogRecord/1"
    service: str = field(metadata={"unit": ""})
    level: str = field(metadata={"unit": ""})
    logger: str = field(metadata={"unit": ""})
    text: str = field(metadata={"unit": ""})


class BusLog(logging.Handler):
    """Writes what is logged to ``/<service>/log:o`` and answers the verb ``log``.

    Records are written by the thread that logs: an output may be written by any.
    """

    def __init__(self, node: "Node"):
        super().__init__(logging.INFO)
        self._service = node.name
        self._recent: deque[dict[str, Any]] = deque(maxlen=RECENT)
        self._output = node.output(f"/{node.name}/log:o", LogRecord)
        node.verb("log", self._answer, "the last records; or their level, read or set")
        _hear_from(logging.INFO)
        logging.getLogger().addHandler(self)
        node.on_close.append(lambda: logging.getLogger().removeHandler(self))

    def emit(self, record: logging.LogRecord) -> None:
        """Keep a record and write it; nothing that is logged may end a service."""
        try:
            text = self.format(record)[:LONGEST]
            level = record.levelname.lower()
            stamp = int(record.created * 1e9)
            self._recent.append(
                {"time_ns": stamp, "level": level, "logger": record.name, "text": text}
            )
            if self._output.standing:
                said = LogRecord(service=self._service, level=level, logger=record.name, text=text)
                # the session's clock is not asked: it may be what complains here
                self._output.write(said, stamp=stamp, clock=WALL)
        except (BusError, ValueError, TypeError):
            self.handleError(record)

    def _answer(self, action: str = "recent", value: str = "") -> Any:
        if action == "recent":
            return list(self._recent)
        if action != "level":
            raise ValueError(f"log: expected action recent or level, got {action!r}")
        if value:
            self.setLevel(level_of(value))
            _hear_from(self.level)
        return logging.getLevelName(self.level).lower()


def level_of(name: str) -> int:
    """Return the number of a level; raise ValueError for an unknown name."""
    if name.lower() not in LEVELS:
        raise ValueError(f"log level: expected one of {', '.join(LEVELS)}, got {name!r}")
    return logging.getLevelNamesMapping()[name.upper()]


def _hear_from(level: int) -> None:
    """Let records of a level reach the handlers, which choose for themselves."""
    root = logging.getLogger()
    root.setLevel(min(root.level, level))
