"""Browsers that load the page are noticed."""

import socket
from collections.abc import Iterator

import pytest

from bus.testing import eventually
from dashboard.config import DashboardConfig
from dashboard.loading import Loading
from dashboard.server import PageServer, open_server
from tests.dashboard.test_server import join


@pytest.fixture
def server() -> Iterator[PageServer]:
    opened = open_server(DashboardConfig())
    yield opened
    opened.stop()


@pytest.fixture
def loading(server) -> Iterator[Loading]:
    opened = Loading(server)
    yield opened
    opened.close()


def test_nobody_loads_a_page_that_nobody_asks_for(loading):
    assert not loading.look()


def test_a_request_for_the_page_begins_to_load_it(server, loading):
    with socket.create_connection((server.get_host(), server.get_port())) as browser:
        browser.sendall(b"GET / HTTP/1.1\r\nHost: localhost\r\n\r\n")
        eventually(loading.look)
        assert loading.look()  # it takes longer than one look


def test_a_browser_that_goes_away_before_it_draws_ends_the_loading(server, loading):
    with join(server, None) as page:
        assert page.recv(timeout=10)
        eventually(loading.look)
    eventually(lambda: not loading.look())
