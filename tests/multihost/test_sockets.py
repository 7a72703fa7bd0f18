"""What is done to Zenoh's sockets behind its back."""

import errno
import os
import socket

import pytest

from bus.sockets import (
    LINGER,
    abandon_dials,
    close_connection,
    endpoint_address,
    let_go,
    unlinked,
)


@pytest.fixture
def connection():
    """Both ends of a connection of this process."""
    with socket.create_server(("127.0.0.1", 0)) as server:
        with socket.create_connection(server.getsockname()) as near, server.accept()[0] as far:
            yield near, far


def lingers(end: socket.socket) -> bool:
    value = end.getsockopt(socket.SOL_SOCKET, socket.SO_LINGER, LINGER.size)
    return LINGER.unpack(value)[0] != 0


def test_what_would_linger_is_let_go_and_the_rest_is_left_alone(connection):
    near, far = connection
    for end in connection:
        end.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, LINGER.pack(1, 10))
    before = unlinked()
    assert let_go(near.getsockname(), far.getsockname(), 2.0)
    assert not lingers(near) and lingers(far)
    assert near.getsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT) == 2000
    assert far.getsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT) == 0
    assert not let_go(near.getsockname(), far.getsockname(), 2.0)
    assert before - unlinked() == {os.fstat(near.fileno()).st_ino}


def test_a_socket_that_listens_or_does_not_linger_is_no_link_to_come(connection):
    before = unlinked()
    with socket.create_server(("127.0.0.1", 0)) as server:
        server.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, LINGER.pack(1, 10))
        assert unlinked() == before


def test_a_connection_is_ended_by_its_addresses(connection):
    near, far = connection
    assert not close_connection(near.getsockname(), near.getsockname())
    assert close_connection(near.getsockname(), far.getsockname())
    assert near.recv(1) == far.recv(1) == b""


def test_a_dial_without_an_answer_is_abandoned(connection):
    with socket.create_server(("127.0.0.1", 0), backlog=0) as full:
        with socket.create_connection(full.getsockname()), socket.socket() as dial:
            dial.setblocking(False)
            assert dial.connect_ex(full.getsockname()) == errno.EINPROGRESS
            assert abandon_dials() == 1
            assert dial.getsockopt(socket.SOL_SOCKET, socket.SO_ERROR) == errno.ECONNRESET


@pytest.mark.parametrize(
    ("endpoint", "address"),
    [
        ("tcp/10.0.0.1:7512", ("10.0.0.1", 7512)),
        ("tls/[fe80::1]:80#a=b", ("fe80::1", 80)),
    ],
)
def test_endpoints_have_addresses(endpoint, address):
    assert endpoint_address(endpoint) == address
