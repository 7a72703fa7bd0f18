"""A link of which nothing is read is closed, and made anew by who looks for lost peers."""

import socket
from collections.abc import Iterator
from typing import NamedTuple

import pytest

from bus import unheard
from bus.unheard import PATIENCE, Unheard


class Link(NamedTuple):
    """What Zenoh tells of a link."""

    src: str
    dst: str


@pytest.fixture
def ends() -> Iterator[tuple[socket.socket, socket.socket, Link]]:
    """Return our end of a connection, the other one, and its link."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        with socket.create_connection(server.getsockname()) as own:
            other, _ = server.accept()
            host, port = own.getsockname()
            with other:
                yield own, other, Link(f"tcp/{host}:{port}", "tcp/{}:{}".format(*own.getpeername()))


@pytest.fixture
def links(monkeypatch, ends) -> Unheard:
    monkeypatch.setattr(unheard, "LOOK", 0.0)
    links = Unheard()
    links.began(ends[2])
    return links


def is_closed(end: socket.socket) -> bool:
    end.setblocking(False)
    try:
        return end.recv(1) == b""
    except BlockingIOError:
        return False


def test_a_link_that_is_not_read_is_closed(links, ends):
    _, other, _ = ends
    other.sendall(b"hello")
    for _ in range(PATIENCE - 1):
        links.look()
    assert links.any and not is_closed(other)
    links.look()
    assert not links.any and is_closed(other)


def test_a_link_that_is_read_is_looked_at_no_more(links, ends):
    own, other, _ = ends
    other.sendall(b"hello")
    links.look()
    assert own.recv(5) == b"hello"
    links.look()
    assert not links.any and not is_closed(other)


def test_a_link_on_which_nobody_speaks_is_waited_for(links, ends):
    for _ in range(3 * PATIENCE):
        links.look()
    assert links.any and not is_closed(ends[1])


def test_a_link_that_is_gone_is_forgotten(links, ends):
    ends[0].close()
    links.look()
    assert not links.any
