"""``wrenchbus log``: what the services log."""

from datetime import datetime
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deploy.completion import complete_service
from deploy.errors import UsageError
from deploy.options import Json, on_the_bus
from deploy.output import print_json, print_line, print_warning

if TYPE_CHECKING:
    from bus import Node


class Level(StrEnum):
    """How serious a record is."""

    debug = "debug"
    info = "info"
    warning = "warning"
    error = "error"


@on_the_bus
def log(
    node: "Node",
    service: Annotated[
        str | None,
        typer.Argument(
            help="Service, as torque_observer; default: all.", autocompletion=complete_service
        ),
    ] = None,
    level: Annotated[Level, typer.Option(help="Show nothing less serious.")] = Level.debug,
    follow: Annotated[bool, typer.Option("--follow", "-f", help="Go on with new ones.")] = False,
    count: Annotated[
        int, typer.Option("-n", "--count", min=0, help="Records from before to show.")
    ] = 50,
    set_level: Annotated[
        Level | None, typer.Option(help="Let the service log so much from now on.")
    ] = None,
    as_json: Json = False,
) -> None:
    """Show what services have logged lately; with --follow also what they log from now on.

    A service keeps its last 200 records. With --json one object per line.
    """
    from deploy.log_records import Follower, severity

    if set_level is not None:
        _set_level(node, service, set_level, as_json)
        return
    follower = Follower(node, service) if follow else None
    least = severity(level.value)
    wanted = [r for r in _before(node, service) if severity(r["level"]) >= least]
    for record in wanted[max(len(wanted) - count, 0) :]:
        _show(record, as_json)
    for record in follower.records() if follower else ():
        if severity(record["level"]) >= least:
            _show(record, as_json)


def _before(node: "Node", service: str | None) -> list[dict[str, Any]]:
    from bus import RpcAbsent, RpcTimeout
    from deploy.discovery import require_service
    from deploy.log_records import recent, services_that_log

    if service is not None:
        require_service(node, service)
        return recent(node, service)
    records = []
    for each in services_that_log(node):
        try:
            records += recent(node, each)
        except (RpcAbsent, RpcTimeout) as error:
            print_warning(str(error))
    return sorted(records, key=lambda record: record["time_ns"])


def _set_level(node: "Node", service: str | None, level: Level, as_json: bool) -> None:
    from deploy.discovery import rpc_port

    if service is None:
        raise UsageError("--set-level needs a SERVICE")
    request = {"action": "level", "value": level.value}
    answer = node.call(rpc_port(node, service), "log", request)
    if as_json:
        print_json(answer)
    else:
        print_line(f"{service} logs {level.value} and above")


def _show(record: dict[str, Any], as_json: bool) -> None:
    if as_json:
        print_json(record)
        return
    when = datetime.fromtimestamp(1e-9 * record["time_ns"]).strftime("%H:%M:%S.%f")[:-3]
    level = record["level"].upper()
    print_line(f"{when} {level:<7} {record['service']} {record['logger']}: {record['text']}")
