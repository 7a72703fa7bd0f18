"""The hub: where processes meet and names are granted. No data stops when it dies."""

import argparse
import faulthandler
import logging
import signal
import sys
from pathlib import Path

import zenoh

from bus import runtime_directory
from bus.claims import Arbiter
from bus.errors import BusError
from bus.logs import LEVELS, BusLog
from bus.node import Node
from bus.session import open_session
from bus.signals import stop_flag
from bus.wishes import WishServer, state_directory

DEFAULT_PORT = 7512  # not Zenoh's own 7447, which a ROS router may hold
SETTLE = 0.7  # s after a start in which peers of a former hub come back before names are granted


def arguments() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    parser = argparse.ArgumentParser(
        prog="python -m bus.hub",
        description=__doc__,
        epilog=f"example: python -m bus.hub --listen tcp/127.0.0.1:{DEFAULT_PORT}",
    )
    parser.add_argument("-l", "--listen", default=f"tcp/127.0.0.1:{DEFAULT_PORT}")
    parser.add_argument("-c", "--config", help="Zenoh configuration file (JSON5)")
    parser.add_argument("--namespace", default="", help="prefix of all keys")
    parser.add_argument("--insecure", action="store_true", help="allow other machines, unprotected")
    parser.add_argument(
        "--settle", type=float, default=SETTLE, help="s without grants at the start"
    )
    parser.add_argument(
        "--state", metavar="DIR", help="where connections are kept for good (default: this user's)"
    )
    parser.add_argument("--no-announce", action="store_true", help="leave the runtime directory be")
    parser.add_argument("--log-level", default="warning", type=str.lower, choices=LEVELS)
    return parser


def run(options: argparse.Namespace) -> None:
    """Be the hub until asked to end."""
    session = open_session(
        *("router", (), [options.listen], "", options.config, options.insecure),
    )
    arbiter = Arbiter(session, options.settle)
    wishes = WishServer(session, _state(options))
    entry = None
    try:
        with Node(
            "hub",
            connect=options.listen,
            listen=f"{options.listen.rpartition(':')[0]}:0",
            namespace=options.namespace,
            insecure=options.insecure,
        ) as node:
            BusLog(node)
            node.ready()
            if not options.no_announce:
                entry = runtime_directory.announce(options.listen, options.namespace)
            while node.running:
                node.wait(1.0)
    finally:
        if entry is not None:
            runtime_directory.remove(entry)
        wishes.close()
        arbiter.close()
        session.close()


def _state(options: argparse.Namespace) -> Path | None:
    """Return where wishes are kept: a hub that nobody is told of keeps them in memory."""
    if options.state:
        return Path(options.state)
    return None if options.no_announce else state_directory()


def main() -> int:
    """Run the command; return its exit status."""
    stop_flag.install()  # from here on a signal ends the process with status 0
    faulthandler.register(signal.SIGUSR1)  # kill -USR1 shows where it hangs
    parser = arguments()
    options = parser.parse_args()
    if options.listen.endswith(":0"):
        parser.error(f"--listen: expected a certain port, which others find, got {options.listen}")
    logging.basicConfig(
        level=options.log_level.upper(), format="%(levelname)s %(name)s: %(message)s"
    )
    zenoh.init_log_from_env_or("error")
    try:
        run(options)
    except BusError as error:
        if not stop_flag.set:
            print(f"hub: {error}", file=sys.stderr)
            return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
