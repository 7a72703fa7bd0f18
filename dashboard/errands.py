"""Calls to other services on behalf of the page, beside its loop."""

from collections.abc import Callable
from concurrent.futures import Future, ThreadPoolExecutor
from typing import Any, NamedTuple

from bus import BusError, Node, RpcAbsent

WORKERS = 4  # one slow service must not hold up the button of another


class Outcome(NamedTuple):
    """How a call ended."""

    label: str
    value: Any
    error: BusError | None

    @property
    def absent(self) -> bool:
        """Whether nobody was there to answer."""
        return isinstance(self.error, RpcAbsent)


class Errands:
    """Runs calls in threads of its own; the loop collects how they ended."""

    def __init__(self, node: Node):
        self._node = node
        self._workers = ThreadPoolExecutor(WORKERS, thread_name_prefix="errand")
        self._open: list[tuple[Future[Outcome], Callable[[Outcome], None]]] = []

    def send(
        self,
        label: str,
        port: str,
        verb: str,
        arguments: dict[str, Any],
        timeout: float,
        then: Callable[[Outcome], None],
    ) -> None:
        """Call ``verb`` on ``port``; ``then`` runs in the loop, from ``collect``."""
        future = self._workers.submit(self._call, label, port, verb, arguments, timeout)
        self._open.append((future, then))

    def _call(
        self, label: str, port: str, verb: str, arguments: dict[str, Any], timeout: float
    ) -> Outcome:
        try:
            return Outcome(label, self._node.call(port, verb, arguments, timeout=timeout), None)
        except BusError as error:
            return Outcome(label, None, error)

    def collect(self) -> None:
        """Run what follows the calls that have ended."""
        ended = [entry for entry in self._open if entry[0].done()]
        self._open = [entry for entry in self._open if not entry[0].done()]
        for future, then in ended:
            then(future.result())

    def close(self) -> None:
        """Start no more calls; those under way end by their own time limits."""
        self._workers.shutdown(wait=False, cancel_futures=True)
