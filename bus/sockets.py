"""The TCP connections of this process, which Zenoh opens and gives no handle of."""

import os
import socket
import stat
import struct
import sys
from collections.abc import Callable, Container
from contextlib import suppress
from fcntl import ioctl
from pathlib import Path
from termios import FIONREAD

DESCRIPTORS = Path("/proc/self/fd")  # Linux; elsewhere nothing is found
SYN_SENT = 2  # <netinet/tcp.h>
RECEIVED = 128  # where tcpi_bytes_received is in <linux/tcp.h>'s struct tcp_info
LINGER = struct.Struct("ii")  # struct linger: on, seconds
MOST_RELEASED = 4096

Address = tuple[str, int]  # host, port
Ends = tuple[Address, Address]  # own, other

_released: set[int] = set()  # inodes of the connections that linger no more


def endpoint_address(endpoint: str) -> Address:
    """Return host and port of ``tcp/HOST:PORT``."""
    host, _, port = endpoint.partition("/")[2].partition("#")[0].rpartition(":")
    return host.strip("[]"), int(port)


def own_address(host: str, port: int) -> str:
    """Return the address from which this machine reaches another; raise OSError without a way."""
    family, kind, _, _, address = socket.getaddrinfo(host, port, type=socket.SOCK_DGRAM)[0]
    with socket.socket(family, kind) as probe:
        probe.connect(address)  # sends nothing
        return probe.getsockname()[0]


def let_go(own: Address, other: Address, patience: float) -> bool:
    """Let the connection between two addresses not linger when it is closed.

    Args:
        patience: After so many seconds without an acknowledgement the kernel gives the
            connection up, instead of sending what is old by then; 0: never.

    Returns:
        Whether that is new; False when there is none.
    """

    def release(connection: socket.socket) -> bool:
        if not _joins(connection, own, other):
            return False
        _released.add(_inode(connection))
        return _lingers(connection) and _set(connection, patience)

    if len(_released) > MOST_RELEASED:
        _released.clear()
    return _each(release, _released) > 0


def unlinked() -> set[int]:
    """Return the inodes of connections that linger: Zenoh's, of which no link was made yet."""
    found: set[int] = set()

    def look(connection: socket.socket) -> bool:
        connection.getpeername()  # raises where it is not connected
        if lingers := _lingers(connection):
            found.add(_inode(connection))
        return lingers

    _each(look, _released)
    return found


def close_connection(own: Address, other: Address) -> bool:
    """End the connection between two addresses, as if the other side had; return if it was."""

    def end(connection: socket.socket) -> bool:
        found = _joins(connection, own, other)
        if found:
            connection.shutdown(socket.SHUT_RDWR)
        return found

    return _each(end) > 0


def read_and_waiting() -> dict[Ends, tuple[int, int]]:
    """Return of every connection how many bytes were read so far, and how many wait to be."""
    found: dict[Ends, tuple[int, int]] = {}

    def measure(connection: socket.socket) -> bool:
        ends = connection.getsockname()[:2], connection.getpeername()[:2]
        waiting = struct.unpack("i", ioctl(connection, FIONREAD, bytes(4)))[0]
        told = connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, RECEIVED + 8)
        found[ends] = int.from_bytes(told[RECEIVED:], sys.byteorder) - waiting, waiting
        return True

    _each(measure)
    return found


def abandon_dials() -> int:
    """Let all connections fail that wait for their first answer; return how many."""

    def abandon(connection: socket.socket) -> bool:
        waits = connection.getsockopt(socket.IPPROTO_TCP, socket.TCP_INFO, 1)[0] == SYN_SENT
        if waits:
            connection.shutdown(socket.SHUT_RDWR)
        return waits

    return _each(abandon)


def _each(action: Callable[[socket.socket], bool], but: Container[int] = ()) -> int:
    """Do something to every connection but those inodes; return how often it was done."""
    if not DESCRIPTORS.is_dir():
        return 0
    return sum(_try(int(name), action, but) for name in os.listdir(DESCRIPTORS))


def _try(descriptor: int, action: Callable[[socket.socket], bool], but: Container[int]) -> bool:
    """Do it to one descriptor, which may be closed, or become another, at any time."""
    with suppress(OSError):
        status = os.fstat(descriptor)
        if stat.S_ISSOCK(status.st_mode) and status.st_ino not in but:
            with socket.socket(fileno=os.dup(descriptor)) as connection:
                if connection.family in (socket.AF_INET, socket.AF_INET6):
                    return connection.type == socket.SOCK_STREAM and action(connection)
    return False


def _joins(connection: socket.socket, own: Address, other: Address) -> bool:
    return connection.getsockname()[:2] == own and connection.getpeername()[:2] == other


def _inode(connection: socket.socket) -> int:
    return os.fstat(connection.fileno()).st_ino


def _lingers(connection: socket.socket) -> bool:
    value = connection.getsockopt(socket.SOL_SOCKET, socket.SO_LINGER, LINGER.size)
    return LINGER.unpack(value)[0] != 0


def _set(connection: socket.socket, patience: float) -> bool:
    connection.setsockopt(socket.SOL_SOCKET, socket.SO_LINGER, LINGER.pack(0, 0))
    if patience and hasattr(socket, "TCP_USER_TIMEOUT"):
        timeout = int(1000 * patience)  # ms
        connection.setsockopt(socket.IPPROTO_TCP, socket.TCP_USER_TIMEOUT, timeout)
    return True
