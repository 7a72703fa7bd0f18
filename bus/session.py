"""The one place that opens Zenoh sessions, with settings that were found to work."""

import json
import logging
import os
import re
from collections.abc import Iterable
from ipaddress import ip_address
from pathlib import Path
from typing import Any

import zenoh

from bus import runtime_directory
from bus.errors import BusError
from bus.links import look_after_links
from bus.sockets import endpoint_address, own_address

logger = logging.getLogger(__name__)

LEASE = 2.0  # s until a stopped process's names vanish; a killed one's vanish at once
MAX_MESSAGE = 4 << 20  # bytes on any link; each port has a smaller limit of its own
LOOPBACK = "tcp/127.0.0.1:0"

# One of Zenoh's threads waits for the links and reads them. By default two take turns in
# reading and a third one waits: every message then wakes one thread more, a third of its cost.
_RUNTIME = "(rx: (worker_threads: 1), net: (handover: rx), acc: (handover: rx))"

_SOURCE_LINE = re.compile(r" at \S+\.rs:\d+\.?")  # which Zenoh adds for its own developers

# PROTOCOL/HOST:PORT, perhaps with Zenoh's options behind it, or a path
_ENDPOINT = re.compile(r"(unixsock-stream|unixpipe|serial)/.+|[a-z]+/.+:\d+([?#].*)?")

_unprotected: list[str] = []  # endpoints of this process that leave the machine

_SETTINGS = {
    "scouting/multicast/enabled": False,
    "scouting/gossip/enabled": True,
    "transport/shared_memory/enabled": False,  # no gain below 4 KB, and it can lose silently
    "transport/link/tx/lease": int(1000 * LEASE),
    # less, and on a loaded machine Zenoh gives up links half open: it sends on them, and reads none
    "transport/unicast/open_timeout": 10000,
    "open/return_conditions/connect_scouted": False,  # else up to 0.5 s; Node.ready meets the peers
    "connect/timeout_ms": -1,  # an absent hub is waited for in the background
    "connect/exit_on_failure": False,
    "connect/retry": {"period_init_ms": 100, "period_max_ms": 200, "period_increase_factor": 2},
    "transport/link/tx/queue/size/real_time": 16,  # with 2, express and DROP lose under load
    "transport/link/tx/queue/size/data_high": 16,  # bundles
    "transport/link/tx/queue/size/data": 16,  # large messages, in pieces of 64 KB
    "transport/link/tx/queue/size/interactive_high": 16,  # reliable ones, likewise
    # a reader that does not take a reliable message within 20 ms is disconnected, not waited for
    "transport/link/tx/queue/congestion_control/block/wait_before_close": 20000,
    "transport/link/rx/max_message_size": MAX_MESSAGE,
}


def open_session(
    mode: str = "peer",
    connect: Iterable[str] = (),
    listen: Iterable[str] = (),
    namespace: str = "",
    zenoh_config: str | Path | None = None,
    insecure: bool = False,
) -> zenoh.Session:
    """Open a session; ``zenoh_config`` is a JSON5 file laid under our settings.

    Endpoints that leave this machine are refused unless ``insecure``: without
    certificates anybody on the network could move the robot.
    """
    endpoints = [*connect, *listen]
    if zenoh_config is None:
        check_local(endpoints, insecure)
    os.environ.setdefault("ZENOH_RUNTIME", _RUNTIME)  # read when the first session opens
    settings: dict[str, Any] = {**_SETTINGS, "mode": mode}
    settings["connect/endpoints"], settings["listen/endpoints"] = list(connect), list(listen)
    if namespace:
        settings["namespace"] = namespace
    try:
        config = zenoh.Config.from_file(str(zenoh_config)) if zenoh_config else zenoh.Config()
        for key, value in settings.items():
            config.insert_json5(key, json.dumps(value))
        session = zenoh.open(config)
    except (zenoh.ZError, ValueError, OSError) as error:
        why = _SOURCE_LINE.sub("", str(error))
        raise BusError(f"cannot open the bus ({', '.join(endpoints)}): {why}") from error
    look_after_links(session, LEASE)
    return session


def where_to_listen(hub: str, insecure: bool = False) -> str:
    """Return where others reach a session that joins a hub, when nobody says.

    That is the address from which the hub is reached, if links without protection may leave
    this machine: else two that both joined from elsewhere would never be linked.
    """
    if is_local(hub) or not hub.startswith("tcp/") or not insecure:
        return LOOPBACK
    try:
        host = own_address(*endpoint_address(hub))
    except OSError:  # no way there, for the time being
        return LOOPBACK
    return f"tcp/[{host}]:0" if ":" in host else f"tcp/{host}:0"


def check_local(endpoints: Iterable[str], insecure: bool = False) -> None:
    """Raise when an endpoint can be reached from, or reaches, another machine.

    ``insecure`` permits it; so does a bus that was announced on this machine as insecure.
    Then it is said, once per process.
    """
    remote = [endpoint for endpoint in map(_checked, endpoints) if not is_local(endpoint)]
    for endpoint in remote:
        if not (insecure or runtime_directory.is_insecure(endpoint)):
            raise BusError(
                f"endpoint {endpoint} leaves this machine and nothing protects it: expected"
                " tcp/127.0.0.1:PORT; pass --insecure to allow it, or a Zenoh configuration"
                " (-c) with certificates"
            )
    silent = not _unprotected
    _unprotected.extend(endpoint for endpoint in remote if endpoint not in _unprotected)
    if silent and remote:
        logger.warning("%s", insecure_notice())


def _checked(endpoint: str) -> str:
    if not _ENDPOINT.fullmatch(endpoint):
        raise BusError(f"bad endpoint {endpoint!r}: expected such as tcp/127.0.0.1:7512")
    return endpoint


def insecure_notice() -> str:
    """Return what users must know about this process's unprotected links; empty when none."""
    if not _unprotected:
        return ""
    listed = ", ".join(_unprotected)
    return f"insecure: everybody on the network can read and move the robot ({listed})"


def is_local(endpoint: str) -> bool:
    """Tell whether an endpoint such as ``tcp/127.0.0.1:7512`` stays on this machine."""
    protocol, _, address = endpoint.partition("/")
    host = address.rpartition(":")[0].strip("[]")
    try:
        local = ip_address(host).is_loopback
    except ValueError:  # a name
        local = host == "localhost"
    return protocol in ("unixsock-stream", "unixpipe") or local
