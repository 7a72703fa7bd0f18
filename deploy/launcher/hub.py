"""The hub of an application: started here, or waited for."""

import time
from collections.abc import Callable

from deploy.errors import CommandError
from deploy.launcher.endpoints import accepts
from deploy.launcher.logs import Log
from deploy.launcher.parts import Hub
from deploy.launcher.process import Process

DEADLINE = 60.0  # [s], for a very busy machine; a hub that ends is noticed at once
LOOK = 0.5  # [s] between looks for a hub elsewhere


def await_start(hub: Process, endpoint: str, stopping: Callable[[], bool]) -> None:
    """Wait until a hub that was started here listens.

    Raises:
        CommandError: It does not.
    """
    deadline = time.monotonic() + DEADLINE
    while not accepts(endpoint):
        if not hub.alive:
            raise CommandError(f"the hub ended at once; is {endpoint} free?")
        if time.monotonic() > deadline or stopping():
            raise CommandError(f"the hub does not listen on {endpoint}")
        time.sleep(0.01)


def await_hub(hub: Hub, log: Log, ends: Callable[[], bool]) -> bool:
    """Wait for the hub of another host; return whether it came before ``ends()``."""
    if accepts(hub.endpoint):
        return True
    log.say("launcher", f"waits for the hub of host {hub.host} at {hub.endpoint}; is it up there?")
    while not accepts(hub.endpoint):
        if ends():
            return False
        time.sleep(LOOK)
    log.say("launcher", "found the hub")
    return True
