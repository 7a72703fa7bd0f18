"""What several tests of the bus need."""

from collections.abc import Iterator

import pytest

from bus import Node


@pytest.fixture
def writer(hub: str) -> Iterator[Node]:
    with Node("writer", connect=hub, signals=False) as node:
        yield node
