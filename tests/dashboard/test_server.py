import os
import socket

import pytest
import viser
from pydantic import ValidationError
from websockets.exceptions import ConnectionClosed
from websockets.sync.client import connect
from websockets.typing import Origin, Subprotocol

from bus.testing import eventually
from dashboard.config import DashboardConfig
from dashboard.port_holder import PortBusyError, holder, require_free
from dashboard.server import PageServer, open_server


@pytest.fixture(scope="module")
def server():
    opened = open_server(DashboardConfig(trusted_origins=["https://robot.example"]))
    yield opened
    opened.stop()


@pytest.fixture
def taken():
    with socket.create_server(("127.0.0.1", 0)) as listening:
        yield listening.getsockname()[1]


def join(server: PageServer, origin: str | None):
    url = f"ws://127.0.0.1:{server.get_port()}"
    version = Subprotocol(f"viser-v{viser.__version__}")
    return connect(url, origin=Origin(origin) if origin else None, subprotocols=[version])


def test_port_zero_becomes_a_free_one(server):
    assert server.url == f"http://127.0.0.1:{server.get_port()}"
    assert server.get_port() > 0


def test_page_listens_on_loopback_only(server):
    assert server.get_host() == "127.0.0.1"
    with pytest.raises(ValidationError, match="loopback"):
        DashboardConfig(host="0.0.0.0")


def test_busy_port_is_refused_and_its_holder_named(taken):
    with pytest.raises(PortBusyError, match=f"port {taken} .* taken by pid {os.getpid()} "):
        require_free("127.0.0.1", taken)


def test_holder_of_a_port_that_nobody_shows_is_another_process():
    with socket.socket() as bound:
        bound.bind(("127.0.0.1", 0))
        assert holder(bound.getsockname()[1]) == "another process"


def test_own_page_receives_the_scene(server):
    with join(server, f"http://127.0.0.1:{server.get_port()}") as page:
        assert page.recv(timeout=10)


def test_trusted_proxy_receives_the_scene(server):
    with join(server, "https://robot.example") as page:
        assert page.recv(timeout=10)


def test_page_of_a_foreign_site_is_refused(server):
    with join(server, "https://evil.example") as page, pytest.raises(ConnectionClosed) as closed:
        while True:
            page.recv(timeout=10)
    assert closed.value.rcvd is not None and closed.value.rcvd.code == 1008
    eventually(lambda: not server.get_clients())


def test_nobody_gets_a_public_tunnel(server):
    assert server.request_share_url() is None
