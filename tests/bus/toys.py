"""Small services that the tests of the bus start as processes: ``python -m tests.bus.toys``."""

import logging
import threading
import time

from pydantic import BaseModel, ConfigDict, Field

from bus import Input, Node, Pending
from bus.service import serve
from tests.bus.messages import Mixed, Number

logger = logging.getLogger("tests.bus.toys")


class Settings(BaseModel):
    """Settings of the toy."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    factor: float = Field(default=2.0, gt=0.0)
    output: str = "/toy/out:o"
    rate: float = 200.0
    lockstep: bool = False
    fail: str = ""


def main(node: Node, settings: Settings) -> None:
    """Double what comes in; write zeros, marked invalid, while nothing comes."""
    inp = node.input(f"/{node.name}/in:i", Number, source="/test/out:o", depth=64, rate=100.0)
    out = node.output(settings.output, Number, rate=settings.rate)
    node.input(f"/{node.name}/big:i", Mixed, source="/test/big:o", max_message=1 << 20)
    node.verb("double", lambda value: 2 * value, help="twice the value")
    node.verb("later", Later(node).ask)
    node.verb("hang", lambda seconds=1.0: time.sleep(seconds))
    node.verb("crash", crash)
    node.verb("say", say)
    if settings.fail:
        raise ValueError(settings.fail)
    node.ready()
    while node.running:
        node.wait(1 / settings.rate)
        step(node, inp, out)


def step(node: Node, inp: Input, out) -> None:
    """Move what has come."""
    while (received := inp.read()) is not None:
        factor = node.parameters.value.factor
        out.write(Number(value=factor * received.data.value), like=received.envelope)
        node.acknowledge(received.envelope.stamp)
    if not inp.fresh and not node.lockstep.enabled:
        out.write(Number(value=0.0), valid=False, reason=inp.reason)


class Later:
    """A verb that answers from another thread."""

    def __init__(self, node: Node):
        self._node = node

    def ask(self, text: str, fail: bool = False) -> Pending:
        """Answer a little later."""
        pending = Pending()
        answer = pending.fail if fail else pending.reply
        threading.Thread(target=lambda: (time.sleep(0.05), answer(text))).start()
        return pending


def crash() -> None:
    """Raise."""
    raise KeyError("no such thing")


def say(level: str, text: str) -> None:
    """Log a line."""
    logger.log(logging.getLevelNamesMapping()[level.upper()], text)


if __name__ == "__main__":
    serve(main, Settings, name="toy")
