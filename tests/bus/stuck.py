"""A service whose leaving of the bus hangs: ``python -m tests.bus.stuck``."""

import time

from pydantic import BaseModel

from bus import Node
from bus.service import serve


class Settings(BaseModel):
    """None."""


class Stuck:
    """A part of a node that does not close."""

    def close(self) -> None:
        time.sleep(600.0)


def main(node: Node, settings: Settings) -> None:
    node._parts.append(Stuck())
    node.ready()
    while node.running:
        node.wait(1.0)


if __name__ == "__main__":
    serve(main, Settings, "stuck")
