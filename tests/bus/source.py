"""A service that tells the time: ``python -m tests.bus.source``."""

import time

from pydantic import BaseModel, ConfigDict

from bus import Node
from bus.periodic import Periodic
from bus.service import serve
from tests.bus.messages import Number


class Settings(BaseModel):
    """Settings of the source."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    rate: float = 200.0  # Hz


def jump(seconds: float) -> None:
    """Let this process's wall clock jump."""
    now, shift = time.time_ns, int(seconds * 1e9)
    time.time_ns = lambda: now() + shift


def main(node: Node, settings: Settings) -> None:
    """Write the monotonic time, which all processes of a machine share."""
    out = node.output(f"/{node.name}/out:o", Number, rate=settings.rate)
    node.verb("jump", jump)
    node.ready()
    loop = Periodic.of(node, 1 / settings.rate)
    while loop.next():
        out.write(Number(value=time.monotonic()))


if __name__ == "__main__":
    serve(main, Settings, "source")
