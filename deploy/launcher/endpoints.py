"""Free ports and who listens on them."""

import socket


def free_port() -> int:
    """Return a TCP port of the loopback that nobody listens on."""
    with socket.socket() as probe:
        probe.bind(("127.0.0.1", 0))
        return probe.getsockname()[1]


def with_free_port(endpoint: str) -> str:
    """Replace port 0 of an endpoint by a free one."""
    address, _, port = endpoint.rpartition(":")
    return f"{address}:{free_port()}" if port == "0" else endpoint


def accepts(endpoint: str) -> bool:
    """Whether somebody listens on a ``tcp/HOST:PORT`` endpoint."""
    host, _, port = endpoint.partition("/")[2].rpartition(":")
    try:
        socket.create_connection((host.strip("[]"), int(port)), timeout=1.0).close()
    except OSError:
        return False
    return True
