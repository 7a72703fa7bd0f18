"""``wrenchbus param``, ``terminate``, ``down``: what is asked of a service or of its launcher."""

import time
from collections.abc import Callable
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deploy.arguments import value as read_value
from deploy.errors import CommandError, UsageError
from deploy.options import Json, Service, on_the_bus
from deploy.output import print_answer, print_json, print_line

if TYPE_CHECKING:
    from bus import Node

Timeout = Annotated[float, typer.Option(min=0.1, help="Seconds until it must be gone.")]


class Action(StrEnum):
    """What to do with a setting."""

    list = "list"
    get = "get"
    set = "set"
    reset = "reset"
    save = "save"


WANTED: dict[Action, tuple[str, ...]] = {
    Action.list: (),
    Action.get: ("name",),
    Action.set: ("name", "value"),
    Action.reset: ("name",),
    Action.save: (),
}


@on_the_bus
def param(
    node: "Node",
    action: Annotated[Action, typer.Argument(help="What to do.")],
    service: Service,
    name: Annotated[str | None, typer.Argument(help="Setting, as support.")] = None,
    value: Annotated[str | None, typer.Argument(help="New value, in YAML.")] = None,
    as_json: Json = False,
) -> None:
    """List, get or set the settings of a running service.

    ``reset`` puts one back to what it was at the start; ``save`` writes those that differ
    from the defaults into a file for ``wrenchbus run --params``.
    """
    from deploy.discovery import rpc_port

    request = _request(action, name, value)
    answer = node.call(rpc_port(node, service), "param", request)
    if as_json:
        print_json(answer)
    else:
        print_answer(answer)


@on_the_bus
def terminate(node: "Node", service: Service, timeout: Timeout = 5.0) -> None:
    """Ask a service to end, as SIGTERM would, and wait until it has.

    One that a launcher looks after is started again if its application says so.
    """
    from deploy.discovery import require_service

    pid = require_service(node, service)["pid"]
    node.call(f"/{service}/rpc:i", "terminate", timeout=timeout)
    _until(node, lambda: pid not in _pids(node, service), timeout, f"{service} (pid {pid})")
    print_line(f"{service} (pid {pid}) has ended")


@on_the_bus
def down(node: "Node", timeout: Timeout = 20.0) -> None:
    """End the application that a launcher runs on this bus, and wait until it has."""
    from bus import RpcAbsent
    from deploy.discovery import is_there

    try:
        node.call("/launcher/rpc:i", "down", timeout=5.0)
    except RpcAbsent:
        raise CommandError(
            "no launcher on this bus; services started one by one end with"
            " wrenchbus terminate SERVICE"
        ) from None
    _until(node, lambda: not is_there(node, "launcher"), timeout, "the launcher")
    print_line("the application has ended")


def _request(action: Action, name: str | None, value: str | None) -> dict[str, Any]:
    given = {"name": name, "value": value}
    wanted = WANTED[action]
    for key in given:
        if (given[key] is not None) != (key in wanted):
            needs = " ".join(["SERVICE", *(key.upper() for key in wanted)])
            raise UsageError(f"expected param {action.value} {needs}")
    if value is not None:
        given["value"] = read_value(value, str(name))
    return {"action": action.value} | {key: given[key] for key in wanted}


def _pids(node: "Node", service: str) -> list[int]:
    return [owner.pid for owner in node.directory.services() if owner.service == service]


def _until(node: "Node", gone: Callable[[], bool], timeout: float, what: str) -> None:
    deadline = time.monotonic() + timeout
    while not gone():
        if not node.running:
            raise KeyboardInterrupt
        if time.monotonic() > deadline:
            raise CommandError(f"{what} is still there after {timeout:g} s")
        time.sleep(0.01)
