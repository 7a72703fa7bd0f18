"""A service that judges what it gets from the source: ``python -m tests.bus.sink``."""

import time
from dataclasses import asdict, dataclass
from typing import Any

from pydantic import BaseModel, ConfigDict

from bus import Input, Node
from bus.service import serve
from tests.bus.messages import Number
from tests.bus.source import jump


class Settings(BaseModel):
    """Settings of the sink."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    source: str = "/source/out:o"
    depth: int = 1
    rate: float = 200.0  # Hz


@dataclass
class Report:
    """What the sink has seen."""

    received: int = 0
    fresh: int = 0
    oldest_fresh: float = 0.0  # s; age of the oldest message that was taken for a fresh one
    oldest: float = 0.0  # s; age of the oldest of all
    old: int = 0  # messages of more than a second
    stale: int = 0  # looks at the input at which it was not fresh


class Sink:
    """Reads, and judges."""

    def __init__(self, node: Node, settings: Settings):
        self._node = node
        self._input: Input = node.input(
            *(f"/{node.name}/in:i", Number, settings.source, settings.depth),
            rate=settings.rate,
        )
        self._report = Report()
        node.verb("report", self.report)
        node.verb("jump", jump)

    def report(self, clear: bool = False) -> dict[str, Any]:
        """Tell what was seen since the last time it was cleared."""
        told = self._report
        if clear:
            self._report = Report()
        statistics = self._input.statistics.as_map()
        return asdict(told) | {
            "statistics": statistics,
            "is_fresh": self._input.fresh,
            "reason": self._input.reason,
        }

    def spin(self) -> None:
        """Look once."""
        self._node.wait(0.02)
        while (received := self._input.read()) is not None:
            self._judge(time.monotonic() - received.data.value)
        self._report.stale += not self._input.fresh

    def _judge(self, age: float) -> None:
        report = self._report
        report.received += 1
        report.old += age > 1.0
        report.oldest = max(report.oldest, age)
        if self._input.fresh:
            report.fresh += 1
            report.oldest_fresh = max(report.oldest_fresh, age)


def main(node: Node, settings: Settings) -> None:
    """Judge until asked to end."""
    sink = Sink(node, settings)
    node.ready()
    while node.running:
        sink.spin()


if __name__ == "__main__":
    serve(main, Settings, "sink")
