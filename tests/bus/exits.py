"""Ways in which a process may end: ``python -m tests.bus.exits CASE ENDPOINT``.

None closes its node by hand unless its name says so. Each prints ``ready`` first.
"""

import os
import signal
import sys
import threading
import time

from bus import Node, Pending, reunion
from bus.testing import eventually
from tests.bus.messages import Number


def opened(endpoint: str, signals: bool = True) -> Node:
    """Return a node with one port of each kind, and tell the test."""
    node = Node("ending", connect=endpoint, signals=signals)
    node.output("/ending/x:o", Number)
    node.input("/ending/y:i", Number, source="/ending/x:o", depth=4, rate=100.0)
    node.rpc("/ending/extra/rpc:i", {"wait": Pending})
    node.ready()
    print("ready", flush=True)
    return node


def falls_off_main(endpoint):
    opened(endpoint)


def in_a_with_statement(endpoint):
    with opened(endpoint):
        pass


def sys_exit(endpoint):
    opened(endpoint)
    sys.exit(3)


def unhandled_exception(endpoint):
    opened(endpoint)
    raise LookupError("on purpose")


def unhandled_exception_in_with(endpoint):
    with opened(endpoint):
        raise LookupError("on purpose")


def closed_twice(endpoint):
    node = opened(endpoint)
    node.close()
    node.close()


def closed_in_another_thread(endpoint):
    node = opened(endpoint)
    thread = threading.Thread(target=node.close)
    thread.start()
    node.close()
    thread.join()


def two_nodes_forgotten(endpoint):
    opened(endpoint)
    Node("second", connect=endpoint).input("/second/x:i", Number, source="/ending/x:o")


def waits_for_a_signal(endpoint):
    with opened(endpoint) as node:
        while node.running:
            node.wait(10.0)


def waits_for_a_signal_without_with(endpoint):
    node = opened(endpoint)
    while node.running:
        node.wait(0.001)


def sleeps_on_a_signal(endpoint):
    """Falls off main after the signal, without having waited on the node."""
    node = opened(endpoint)
    while node.running:
        time.sleep(0.01)


def keyboard_interrupt(endpoint):
    """Leaves the signals alone, as a script may."""
    opened(endpoint, signals=False)
    signal.signal(signal.SIGINT, signal.default_int_handler)  # jobs in the background ignore it
    os.kill(os.getpid(), signal.SIGINT)
    time.sleep(10)


def signal_in_a_call(endpoint):
    with opened(endpoint) as node:
        threading.Timer(0.2, os.kill, (os.getpid(), signal.SIGTERM)).start()
        node.call("/ending/extra/rpc:i", "wait", timeout=30.0)


def daemon_thread_reads(endpoint):
    node = opened(endpoint)

    def read():
        while True:
            node.wait(1.0)

    threading.Thread(target=read, daemon=True).start()


def looks_for_a_lost_peer(endpoint):
    """Falls off main while a thread of the session's asks Zenoh without a pause."""
    reunion.FIRST_PAUSE = reunion.LAST_PAUSE = 0.0
    started = _noting_threads()
    node = opened(endpoint)
    with Node("lost", connect=endpoint) as lost:
        peer = str(lost.session.zid())
        eventually(lambda: peer in map(str, node.session.info.peers_zid()))
    eventually(lambda: peer not in map(str, node.session.info.peers_zid()))
    eventually(lambda: "reunion" in [thread.name for thread in started])
    assert not any(thread.daemon for thread in started), "Python's end would not wait for it"


def _noting_threads() -> list[threading.Thread]:
    """Return a list that every thread started from now on is put on."""
    started: list[threading.Thread] = []
    start = threading.Thread.start

    def note(self: threading.Thread) -> None:
        started.append(self)
        start(self)

    threading.Thread.start = note
    return started


def writes_until_the_end(endpoint):
    node = opened(endpoint)
    out = node.output("/ending/more:o", Number)
    for _ in range(1000):
        out.write(Number(value=1.0))


def without_a_hub(endpoint):
    node = Node("ending", connect="tcp/127.0.0.1:9")
    print("ready", flush=True)
    node.ready(timeout=0.3)


def stopped_before_ready(endpoint):
    """SIGTERM while the hub is waited for."""
    with Node("ending", connect="tcp/127.0.0.1:9") as node:
        print("ready", flush=True)
        node.ready(timeout=60.0)


if __name__ == "__main__":
    globals()[sys.argv[1]](sys.argv[2])
