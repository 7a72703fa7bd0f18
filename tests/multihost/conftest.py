"""Three hosts that run one application."""

from collections.abc import Iterator

import pytest

from tests.multihost.lab import Lab
from tests.multihost.network import network, why_not


@pytest.fixture(scope="module")
def lab(tmp_path_factory: pytest.TempPathFactory) -> Iterator[Lab]:
    """Plant and sensor server, estimators, page: each on a host of its own."""
    if reason := why_not():
        pytest.skip(reason)
    folder = tmp_path_factory.mktemp("lab")
    with network(("robot", "brain", "desk"), folder) as hosts:
        yield Lab(hosts, folder)
