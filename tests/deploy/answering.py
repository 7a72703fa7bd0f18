"""A service that answers verbs, in a thread of the test's process."""

import threading
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from typing import Any

from bus import Node

Verbs = Mapping[str, Callable[..., Any]]


@contextmanager
def answering(bus: str, name: str, ports: Mapping[str, Verbs]) -> Iterator[None]:
    """Answer the verbs of RPC ports as the service ``name`` until the end of the block."""
    ended = threading.Event()

    def spin() -> None:
        while not ended.is_set():
            node.wait(0.02)

    with Node(name, connect=bus, signals=False) as node:
        for port, verbs in ports.items():
            node.rpc(port, dict(verbs))
        node.ready()
        thread = threading.Thread(target=spin)
        thread.start()
        try:
            yield
        finally:
            ended.set()
            thread.join()
