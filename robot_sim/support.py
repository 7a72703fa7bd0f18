"""Telling the services what bears the robot."""

import logging
import threading

from bus import BusError, Node, Pending
from robot_model import ports

logger = logging.getLogger(__name__)

TIMEOUT = 1.0  # s per question; a service that hangs must not hold up the others for long


def announce_support(node: Node, robot: str, support: str, answer: dict) -> Pending:
    """Set ``support`` of all services of this robot, in a thread of its own.

    The plant goes on meanwhile. Returns the request's answer: ``answer`` with the
    services that now know (``told``) and those that did not take it (``refused``).
    """
    pending = Pending()

    def announce() -> None:
        told: list[str] = []
        refused: dict[str, str] = {}
        for owner in node.directory.services():
            if owner.service == node.name:
                continue
            if not node.running:
                break
            try:
                if _set_support(node, owner.service, robot, support):
                    told.append(owner.service)
            except BusError as error:
                refused[owner.service] = str(error)
                logger.warning("%s does not know of its support: %s", owner.service, error)
        pending.reply({**answer, "support": support, "told": told, "refused": refused})

    threading.Thread(target=announce, name="support").start()
    return pending


def _set_support(node: Node, service: str, robot: str, support: str) -> bool:
    """Return whether the service has such a setting, for this robot."""
    port = ports.rpc(service)
    settings = node.call(port, "param", {"action": "list"}, TIMEOUT)
    if "support" not in settings or settings.get("robot") != robot:
        return False
    change = {"action": "set", "name": "support", "value": support}
    node.call(port, "param", change, TIMEOUT)
    return True
