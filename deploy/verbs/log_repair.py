"""``wrenchbus log repair``: what is whole in a recording that was cut or spoilt."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from deploy.errors import UsageError
from deploy.options import Json
from deploy.output import print_json, print_line

if TYPE_CHECKING:
    from bus.recording.repair import Repair


def repair(
    file: Annotated[Path, typer.Argument(metavar="CUT.mcap", help="A recording.")],
    output: Annotated[
        Path, typer.Option("-o", "--output", metavar="NEW.mcap", help="Where what is whole goes.")
    ],
    force: Annotated[
        bool, typer.Option("--force", "--overwrite", help="Replace a file that exists.")
    ] = False,
    as_json: Json = False,
) -> None:
    """Rescue what is whole in a recording that was cut or spoilt, into a new one.

    Every message in it has passed a checksum; the bytes that were given up are listed.
    """
    from bus.recording import repair as rescue

    if output.exists() and not force:
        raise UsageError(f"{output} exists already; --force replaces it")
    done = rescue.repair(file, output, overwrite=force)
    if as_json:
        print_json(_as_map(file, output, done))
    else:
        _show(output, done)


def _as_map(file: Path, output: Path, done: "Repair") -> dict:
    return {
        "file": str(file),
        "output": str(output),
        "messages": done.messages,
        "ports": done.ports,
        "seconds": done.seconds,
        "given_up": [gap._asdict() for gap in done.given_up],
        "nameless": done.nameless,
        "missing": done.missing,
    }


def _show(output: Path, done: "Repair") -> None:
    for gap in done.given_up:
        print_line(f"bytes {gap.start} to {gap.end} given up: {gap.reason}")
    if done.nameless:
        print_line(f"{done.nameless} messages given up: the port that they belong to is lost")
    missing = f", {done.missing} are missing" if done.missing else ""
    print_line(
        f"{output}: {done.messages} messages of {done.ports} ports, {done.seconds:.1f} s{missing}"
    )
