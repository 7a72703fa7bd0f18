"""``wrenchbus list``, ``info``: which ports stand and what they carry."""

from typing import TYPE_CHECKING, Any

from deploy.options import Json, Port, on_the_bus
from deploy.output import print_json, print_line, print_table

if TYPE_CHECKING:
    from bus import Node


@on_the_bus
def list_all(node: "Node", as_json: Json = False) -> None:
    """List the ports that stand on the bus."""
    from deploy.discovery import all_ports

    ports = all_ports(node)
    if as_json:
        print_json(ports)
    else:
        rows = [{**port, "owner": _owner(port)} for port in ports]
        print_table(rows, ["name", "type", "direction", "owner", "nominal_hz", "sources"])


@on_the_bus
def info(
    node: "Node",
    port: Port,
    as_json: Json = False,
) -> None:
    """Tell what a port carries: fields, units, frames, statistics."""
    from bus.introspection import port_info
    from deploy.discovery import require_port

    require_port(node, port)
    entry = port_info(node, port)
    if as_json:
        print_json(entry)
        return
    print_line(f"{entry['name']}: {entry['direction']} of {_owner(entry)}, {entry['type']}")
    print_line(f"nominal rate: {entry['nominal_hz']:g} Hz{_of_late(entry)}")
    if entry["sources"]:
        print_line(f"reads: {', '.join(entry['sources'])}")
    if "fresh" in entry:
        print_line(f"state: {entry['reason'] or 'fresh'}")
    for line in entry.get("description", "").strip().splitlines():
        print_line(line.strip())
    if "fields" in entry:
        print_table(entry["fields"], ["name", "type", "shape", "unit", "frame", "optional"])
    if "max_message" in entry:
        print_line(f"largest message: {entry['max_message']} bytes")
    if "queue" in entry:
        print_line(f"queue: {entry['queue']['mode']}, depth {entry['queue']['depth']}")
    for name, value in {**entry.get("statistics", {})}.items():
        print_line(f"{name}: {value}")
    if "error" in entry:
        print_line(f"its owner does not tell more: {entry['error']}")


def _of_late(port: dict[str, Any]) -> str:
    return f"; of late {port['hz']:.4g} Hz" if "hz" in port else ""


def _owner(port: dict[str, Any]) -> str:
    owner = port["owner"]
    return f"{owner['service']} ({owner['host']}, pid {owner['pid']})"
