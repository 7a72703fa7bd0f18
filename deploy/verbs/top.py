"""``wrenchbus top``: what ports and processes do, live."""

import shutil
import sys
import time
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deploy.options import Json, on_the_bus
from deploy.output import print_json, print_line, reader_gone, table_lines

if TYPE_CHECKING:
    from bus import Node
    from deploy.activity import Activity

PORTS = ["port", "hz", "kB/s", "lost", "dropped", "refused", "owner"]
PROCESSES = ["service", "host", "pid", "cpu %", "MB", "ports"]
CLEAR = "\x1b[H\x1b[J"


@on_the_bus
def top(
    node: "Node",
    count: Annotated[
        int | None, typer.Option("-n", "--count", min=1, help="Refresh N times, then end.")
    ] = None,
    interval: Annotated[float, typer.Option(min=0.1, help="Seconds between two.")] = 1.0,
    as_json: Json = False,
) -> None:
    """Show rates, bytes and losses of all ports, and what the processes take.

    Ctrl-C ends it. With --json one document, unless -n asks for more.
    """
    from deploy.activity import Activity

    activity = Activity(node)
    remaining = count or (1 if as_json else None)
    while node.running and remaining != 0 and not reader_gone():
        _sleep(node, interval)
        activity.look()
        _show(node, activity, as_json)
        remaining = None if remaining is None else remaining - 1


def _sleep(node: "Node", seconds: float) -> None:
    end = time.monotonic() + seconds
    while node.running and (remaining := end - time.monotonic()) > 0:
        node.wait(min(remaining, 0.1))


def _show(node: "Node", activity: "Activity", as_json: bool) -> None:
    ports, processes = activity.ports(), activity.processes()
    if as_json:
        print_json({"ports": ports, "processes": processes})
        return
    lines = [f"{node.endpoint}  {time.strftime('%H:%M:%S')}  {len(ports)} ports", ""]
    lines += [*table_lines(list(map(_process, processes)), PROCESSES), ""]
    lines += table_lines(list(map(_port, ports)), PORTS)
    print_line(_fit(lines) if sys.stdout.isatty() else "\n".join([*lines, ""]))


def _fit(lines: list[str]) -> str:
    """Return what fits on the screen, with the order to clear it."""
    columns, rows = shutil.get_terminal_size()
    shown = lines
    if len(lines) > rows - 1:
        shown = [
            *lines[: rows - 2],
            f"... {len(lines) - rows + 2} lines more; wrenchbus top | less",
        ]
    return CLEAR + "\n".join(line[:columns] for line in shown)


def _port(row: dict[str, Any]) -> dict[str, Any]:
    rate = row["bytes_per_s"]
    owner = row["owner"]["service"] + (f" ({row['error']})" if row["error"] else "")
    return row | {"kB/s": None if rate is None else 1e-3 * rate, "owner": owner}


def _process(row: dict[str, Any]) -> dict[str, Any]:
    memory = row["memory_bytes"]
    return row | {"cpu %": row["cpu_percent"], "MB": None if memory is None else memory // 10**6}
