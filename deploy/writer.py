"""Writes onto an input that stands, or under a name of its own, with the type that a port tells."""

import time
from types import TracebackType
from typing import Any, Self

from bus import BusError, Node, Output, WireError
from bus.introspection import port_info, port_infos
from bus.session import MAX_MESSAGE
from deploy.description import describe
from deploy.discovery import all_ports
from deploy.errors import CommandError, UsageError
from deploy.message_text import Composer

MEET = 2.0  # [s] until a reader that stands is linked with us
JUDGE = 1.0  # [s] until the owner of an input has looked at what came
BAD = ("refused", "foreign", "repeated")
COUNTED = ("received", "dropped", *BAD)


class Writer:
    """An output for one run of the command; in a ``with`` statement, whose end tells refusals.

    Args:
        port: An input (``:i``) that stands, or an output (``:o``) to be opened.
        type_of: The port whose type an output gets.
        model: Hash of the joints' names that messages carry; None takes what the port tells.
        take_over: Whether an output may stand; its name is taken from who has it, who then ends.

    Raises:
        UsageError: The port cannot be written.
        NameTaken: Another process has taken the name meanwhile.
    """

    def __init__(
        self,
        node: Node,
        port: str,
        type_of: str | None = None,
        model: str | None = None,
        take_over: bool = False,
    ):
        self._node, self._port = node, port
        if port.endswith(":o"):
            _check_output(node, port, type_of, take_over)
        elif take_over:
            raise UsageError(f"--take-over takes the name of an output (:o), got {port}")
        self._info = describe(node, type_of or port)
        if type_of is None and not take_over and self._info["direction"] != "input":
            raise UsageError(f"{port} is an output of {self._info['owner']['service']}")
        described = (self._info[key] for key in ("type", "fields", "description"))
        self._composer = Composer(*described)
        self._output = self._open(self._info.get("model", "") if model is None else model)
        self._counted = self._count(self._info)

    def write(self, fields: dict[str, Any]) -> None:
        """Write one message; raise UsageError when the fields do not fit the type."""
        self._node.wait(0.0)  # answers who asks, and notices a lost name
        try:
            self._output.write(self._composer.compose(fields))
        except WireError as error:
            raise UsageError(str(error)) from None

    def __enter__(self) -> Self:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, _: TracebackType | None
    ) -> None:
        if error is not None or not self._output.statistics.written:
            return
        if self._counted is not None:
            self._judge()
        else:
            self._round_trips()

    def _open(self, model: str) -> Output:
        limit = self._info.get("max_message", MAX_MESSAGE)
        message_type, direct = self._composer.type, self._port.endswith(":i")
        output = self._node.output(
            self._port, message_type, model=model, reliable=True, max_message=limit
        )
        if not direct:
            self._node.ready()
        if direct or _readers(self._node, self._port):
            self._meet(output, direct)
            self._round_trips()
        return output

    def _round_trips(self) -> None:
        """Ask the readers of our output anything: what we sent before, our name first, is there."""
        port_infos(self._node, _readers(self._node, self._port), MEET)

    def _meet(self, output: Output, must: bool) -> None:
        deadline = time.monotonic() + MEET
        while not output.matched and self._node.running:
            if time.monotonic() > deadline:
                if must:
                    raise CommandError(f"{self._port} does not read: its owner is not linked")
                return
            time.sleep(0.002)

    def _count(self, info: dict[str, Any]) -> dict[str, int] | None:
        """Return how many messages the input has met; None when we do not write to an input."""
        if not self._port.endswith(":i"):
            return None
        statistics = info.get("statistics", {})
        return {name: statistics.get(name, 0) for name in COUNTED}

    def _judge(self) -> None:
        """Wait until the input has met what was written; tell what it would not take."""
        written, before = self._output.statistics.written, self._counted or {}
        deadline = time.monotonic() + JUDGE
        while self._node.running and time.monotonic() < deadline:
            try:
                now = self._count(port_info(self._node, self._port)) or {}
            except BusError:
                return  # it has gone
            if sum(now.values()) - sum(before.values()) >= written:
                self._complain({name: now[name] - before[name] for name in BAD}, written)
                return
            time.sleep(0.01)

    def _complain(self, bad: dict[str, int], written: int) -> None:
        if count := sum(bad.values()):
            owner = self._info["owner"]["service"]
            raise CommandError(
                f"{self._port} took {written - count} of {written} messages; its owner {owner}"
                f" says why in its log (another model? see --model)"
            )


def _check_output(node: Node, port: str, type_of: str | None, take_over: bool) -> None:
    standing = {entry["name"]: entry for entry in all_ports(node)}
    if port in standing and not take_over:
        owner = standing[port]["owner"]
        readers = ", ".join(_readers(node, port)) or "none at present"
        raise UsageError(
            f"{port} is written by {owner['service']} (host {owner['host']}, pid {owner['pid']});"
            f" write onto an input instead (it is read by: {readers}), or --take-over its name"
        )
    if port not in standing and type_of is None:
        raise UsageError(f"{port} does not stand; to open it, say --type-of PORT")


def _readers(node: Node, port: str) -> list[str]:
    return [token.name for token in node.directory.tokens() if port in token.sources]
