"""``wrenchbus log info``, ``export``, ``convert``, ``import-…``: what is done with recordings."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deploy.errors import CommandError, UsageError
from deploy.options import Json
from deploy.output import print_json, print_line, print_table, print_warning

if TYPE_CHECKING:
    from bus.recording import Recording

File = Annotated[Path, typer.Argument(metavar="FILE", help="A recording, as touch.mcap.")]
Ports = Annotated[list[str] | None, typer.Argument(metavar="PORT", help="Ports; default: all.")]
From = Annotated[
    float | None, typer.Option("--from", min=0.0, help="Begin so many seconds after the start.")
]
To = Annotated[
    float | None, typer.Option("--to", min=0.0, help="End so many seconds after the start.")
]
Force = Annotated[bool, typer.Option("--force", "--overwrite", help="Replace OUT if it exists.")]
Out = Annotated[Path, typer.Option("-o", "--output", metavar="OUT", help="What is written.")]
Map = Annotated[
    Path, typer.Option("--map", metavar="MAP.yaml", help="Which stream is which channel.")
]

PORT_COLUMNS = ("name", "type", "messages", "hz", "nominal_hz", "lost", "refused")


def info(file: File, as_json: Json = False) -> None:
    """Show a recording's duration, ports, rates, losses, attachments and metadata."""
    from deploy.recordings.info import describe

    about = describe(_open(file))
    if as_json:
        print_json(about)
        return
    megabytes = about["bytes"] * 1e-6
    print_line(f"{file}: {about['duration_s']:.3f} s, {about['messages']} messages,"
               f" {megabytes:.2f} MB, {about['lost']} lost")  # fmt: skip
    ports = about["ports"]
    print_table([port for port in ports if port["messages"] or port["lost"]], PORT_COLUMNS)
    if silent := [port["name"] for port in ports if not port["messages"]]:
        print_line(f"silent: {' '.join(silent)}")
    for entry in about["attachments"]:
        print_line(f"attached: {entry['name']} ({entry['bytes']} bytes)")
    for name, texts in about["metadata"].items():
        for key, text in texts.items():
            print_line(f"{name}.{key}: {text}")


def diff(
    first: File,
    second: Annotated[Path, typer.Argument(metavar="OTHER", help="Another recording.")],
    ports: Ports = None,
    as_json: Json = False,
) -> None:
    """Compare two recordings, message by message of one stamp; exit status 1 when they differ.

    What belongs to the run aside: source, sequence, times of measurement and sending.
    """
    from bus.recording.difference import differences

    ours, theirs = _open(first), _open(second)
    names = ports or [
        name
        for name, port in ours.ports.items()
        if port.direction == "output" and name in theirs.ports and port.count
    ]
    rows = [
        {"port": name, **found._asdict()}
        for name, found in differences(ours, theirs, names).items()
    ]
    if as_json:
        print_json([{**row, "largest": _finite(row["largest"])} for row in rows])
    else:
        print_table(rows, list(rows[0]) if rows else ["port"])
    raise typer.Exit(int(any(row["differing"] for row in rows)))


def _finite(number: float) -> float | None:
    """JSON knows no infinity, which says that something else than numbers differs."""
    return number if number < float("inf") else None


def export(
    file: File,
    ports: Ports = None,
    out: Out = ...,  # type: ignore[assignment]
    start: From = None,
    end: To = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Write a recording's numbers as one .npz, or as a folder of CSV tables.

    An OUT that ends in .npz gets arrays named PORT/FIELD; any other OUT is a folder with
    one table per port.
    """
    from deploy.recordings.csv_tables import export_csv
    from deploy.recordings.npz import export_npz
    from deploy.recordings.robots import robots_of
    from deploy.recordings.selection import Selection

    recording = _open(file)
    selection = Selection(recording, ports or (), start, end)
    _make_way(file, out, force)
    write = export_npz if out.suffix == ".npz" else export_csv
    try:
        counts = write(selection, robots_of(recording), out)
    except OSError as error:
        raise CommandError(f"{out}: {error.strerror or error}") from None
    _tell(out, counts, selection.undecodable, as_json)


def convert(
    file: File,
    ports: Ports = None,
    out: Out = ...,  # type: ignore[assignment]
    to_json: Annotated[
        bool, typer.Option("--json", help="JSON messages; there is no other format.")
    ] = True,
    rate: Annotated[
        float | None, typer.Option(min=0.1, help="Messages per second and port at most.")
    ] = None,
    session_time: Annotated[
        bool, typer.Option("--session-time", help="Plot over simulated, not wall, time.")
    ] = False,
    start: From = None,
    end: To = None,
    force: Force = False,
) -> None:
    """Write an MCAP file of JSON messages, which PlotJuggler and Foxglove open.

    Joints, sensors and axes are keys. For Foxglove's 3D panel there are the robot and the
    forces on it.
    """
    from deploy.recordings.json_mcap import convert as write
    from deploy.recordings.robots import robots_of
    from deploy.recordings.selection import Selection

    recording = _open(file)
    selection = Selection(recording, ports or (), start, end)
    _make_way(file, out, force)
    try:
        counts = write(recording, selection, robots_of(recording), out, rate, session_time)
    except OSError as error:
        raise CommandError(f"{out}: {error.strerror or error}") from None
    _tell(out, counts, selection.undecodable, as_json=False)


def import_yarp(
    folder: Annotated[Path, typer.Argument(metavar="DIR", help="What yarpdatadumper wrote.")],
    map_file: Map = ...,  # type: ignore[assignment]
    out: Out = ...,  # type: ignore[assignment]
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Make a recording that can be replayed from the folders of yarpdatadumper."""
    from deploy.recordings.foreign.importing import import_yarp as read

    _report(read, folder, map_file, out, force, as_json)


def import_csv(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="A table with a header.")],
    map_file: Map = ...,  # type: ignore[assignment]
    out: Out = ...,  # type: ignore[assignment]
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Make a recording that can be replayed from a table."""
    from deploy.recordings.foreign.importing import import_csv as read

    _report(read, file, map_file, out, force, as_json)


def import_npz(
    file: Annotated[Path, typer.Argument(metavar="FILE", help="An .npz of arrays over time.")],
    out: Out = ...,  # type: ignore[assignment]
    robot: Annotated[str, typer.Option("--robot", help="Whose log it is.")] = "icub",
    grid: Annotated[
        float | None, typer.Option(min=0.1, help="Rate to interpolate to [Hz]; default: none.")
    ] = None,
    force: Force = False,
    as_json: Json = False,
) -> None:
    """Make a recording that can be replayed from arrays, as wrenchbus estimate reads them."""
    from deploy.recordings.foreign.importing import import_npz

    def read(source: Path, name: str, target: Path) -> dict[str, Any]:
        return import_npz(source, name, grid, target)

    _report(read, file, robot, out, force, as_json)


def _open(path: Path) -> "Recording":
    from bus.recording import Recording

    return Recording(path)


def _make_way(source: Path, out: Path, force: bool) -> None:
    """Refuse to write over a file; remove it when that is asked for, unless it is read."""
    if not out.exists():
        return
    if source.exists() and out.samefile(source):
        raise UsageError(f"{out} is the input; expected another file for the output")
    if not force:
        raise UsageError(f"{out} exists already; --force replaces it")
    if not out.is_dir():
        out.unlink()


def _tell(out: Path, counts: dict[str, int], undecodable: dict[str, int], as_json: bool) -> None:
    for port, count in undecodable.items():
        if count:
            print_warning(f"{port}: {count} messages could not be decoded, and are left out")
    if as_json:
        print_json({"file": str(out), "messages": counts, "undecodable": sum(undecodable.values())})
        return
    for name, count in counts.items():
        print_line(f"{name}: {count}")
    print_line(f"written: {out}")


def _report(read: Any, source: Path, how: Any, out: Path, force: bool, as_json: bool) -> None:
    from robot_model.errors import DescriptionError

    _make_way(source, out, force)
    try:
        summary = read(source, how, out)
    except DescriptionError as error:
        raise UsageError(str(error)) from None
    for text in summary["report"]:
        print_warning(text)
    if as_json:
        print_json(summary)
        return
    seconds, hz = summary["duration_s"], summary["hz"]
    print_line(f"written: {out}: {summary['frames']} frames, {seconds:.3f} s at {hz:.6g} Hz")
    shares = [f"{kind} {100.0 * share:.4g} %" for kind, share in summary["valid"].items()]
    print_line(f"measured: {', '.join(shares)}")
    print_line(f"lines left out: {summary['lines_left_out']}")
