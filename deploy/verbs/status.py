"""``wrenchbus status``: which services run."""

from typing import TYPE_CHECKING, Any

from deploy.options import Json, on_the_bus
from deploy.output import print_json, print_table

if TYPE_CHECKING:
    from bus import Node

COLUMNS = ["service", "host", "pid", "state", "ready", "restarts", "uptime_s"]


@on_the_bus
def status(node: "Node", as_json: Json = False) -> None:
    """Tell which services run, and since when."""
    rows = services(node)
    if as_json:
        print_json(rows)
    else:
        print_table(rows, COLUMNS)


def services(node: "Node") -> list[dict[str, Any]]:
    """Return the launcher's answer, or without a launcher the services that are ready."""
    from bus import RpcAbsent
    from bus.introspection import list_services

    try:
        return node.call("/launcher/rpc:i", "status")
    except RpcAbsent:
        ready = {"state": "ready", "ready": True, "restarts": None, "uptime_s": None}
        found = list_services(node)
        return [{**service, **ready} for service in found]
