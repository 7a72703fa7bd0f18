"""``wrenchbus record``: what is on the bus, into a file."""

import sys
import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deploy.completion import complete_port
from deploy.errors import UsageError
from deploy.options import Json, Seconds, on_the_bus
from deploy.output import print_json, print_line, print_table, print_warning

if TYPE_CHECKING:
    from bus import Node
    from services.recorder.session import RecordingSession

PROGRESS = 0.5  # [s]
COLUMNS = ("port", "recorded", "lost", "refused", "unheard", "sources")

Ports = Annotated[
    list[str] | None,
    typer.Argument(
        metavar="[PORT]...",
        help="Ports, as /icub/torques:o; default: all but views of others.",
        autocompletion=complete_port,
    ),
]


@on_the_bus
def record(
    node: "Node",
    ports: Ports = None,
    output: Annotated[
        Path | None, typer.Option("-o", "--output", metavar="FILE.mcap", help="Where to.")
    ] = None,
    everything: Annotated[bool, typer.Option("--all", help="Views of other ports too.")] = False,
    seconds: Seconds = None,
    force: Annotated[
        bool, typer.Option("--force", "--overwrite", help="Replace a file that exists.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Record every message of ports, with proof of what was lost; Ctrl-C ends it.

    Exit status 1 when a message was lost or the disk is full. What a stopped or killed
    recording had flushed, every second, is rescued by wrenchbus log repair.
    """
    from bus.introspection import hear_all
    from bus.threads import be_patient
    from deploy.discovery import require_port

    for port in ports or ():
        require_port(node, port)
    hear_all(node)
    be_patient()
    session = _begin(node, output or _usual_name(), ports or (), everything, force)
    _run(node, session, seconds)
    told = session.status()
    if as_json:
        print_json(told)
    else:
        _summarise(told)
    if told["error"]:
        print_warning(told["error"])
    if told["error"] or told["lost"]:
        raise typer.Exit(1)


def _usual_name() -> Path:
    return Path(time.strftime("wrenchbus-%Y%m%d-%H%M%S.mcap"))


def _begin(
    node: "Node", path: Path, ports: list[str] | tuple[()], everything: bool, force: bool
) -> "RecordingSession":
    from bus.configuration import load
    from services.recorder.config import RecorderConfig
    from services.recorder.session import RecordingSession

    if path.exists() and not force:
        raise UsageError(f"{path} exists already; --force replaces it")
    config = load(RecorderConfig, "services.recorder")
    return RecordingSession(node, path, config, ports, everything, overwrite=force)


def _run(node: "Node", session: "RecordingSession", seconds: float | None) -> None:
    from services.recorder.session import STEP

    shown, end = 0.0, None if seconds is None else time.monotonic() + seconds
    while node.running and session.running and (end is None or time.monotonic() < end):
        node.wait(STEP)
        session.step()
        if sys.stderr.isatty() and time.monotonic() - shown > PROGRESS:
            shown = time.monotonic()
            print(f"\r\x1b[K{_progress(session.status())}", end="", file=sys.stderr, flush=True)
    session.stop()
    if shown:
        print("\r\x1b[K", end="", file=sys.stderr, flush=True)


def _progress(told: dict[str, Any]) -> str:
    text = f"{told['seconds']:.1f} s  {told['size'] * 1e-6:.1f} MB  {len(told['ports'])} ports"
    warning = f"  {told['warning']}" if told["warning"] else ""
    return f"{text}  {told['messages']} messages  {told['lost']} lost{warning}"


def _summarise(told: dict[str, Any]) -> None:
    ports = told["ports"]
    rows = [{"port": name} | counts for name, counts in ports.items() if any(counts.values())]
    if rows:
        print_table(rows, COLUMNS)
    if silent := len(ports) - len(rows):
        print_line(f"{silent} more ports were silent")
    print_line(f"{told['file']}: {_progress(told)}")
