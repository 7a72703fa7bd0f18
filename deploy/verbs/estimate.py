"""``wrenchbus estimate``: torques, wrenches, residuals and contacts of a log."""

import time
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deploy.errors import CommandError, UsageError
from deploy.options import Description, Json
from deploy.output import print_json, print_line, print_warning

if TYPE_CHECKING:
    from deploy.estimate.run import Estimation

LONGEST_TARE = 60.0  # s


def estimate(
    source: Annotated[
        Path, typer.Argument(metavar="INPUT", help="A recording, or an npz of arrays.")
    ],
    out: Annotated[Path, typer.Option("-o", "--output", metavar="OUTPUT.npz", help="Written.")],
    robot: Description = "icub",
    contact: Annotated[
        list[str] | None,
        typer.Option(
            metavar="FRAME[:X,Y,Z][:wrench|force|none|direction=X,Y,Z]",
            help="Where the world acts, and what is unknown of it; repeatable. Takes the place"
            " of the default contact of its sub-tree.",
        ),
    ] = None,
    support: Annotated[
        str | None, typer.Option(help="floor, pole or none; default: floor, if it has one.")
    ] = None,
    tare: Annotated[
        float,
        typer.Option(
            min=0.0, max=LONGEST_TARE, help="Seconds at the start, untouched and at rest."
        ),
    ] = 0.0,
    as_json: Json = False,
) -> None:
    """Estimate the torque of every joint and the wrench on every limb of a log.

    Works without a bus, faster than real time. With motor or link torques in INPUT there
    are residuals and contacts too.
    """
    begin = time.monotonic()
    estimation, touches = _prepare(source, out, robot, contact or [], support)
    if tare > 0.0:
        print_warning(estimation.tare(tare))
    _run(estimation)
    from deploy.estimate.output import arrays_of, write_npz

    arrays = arrays_of(estimation)
    write_npz(arrays, out)
    _tell(_summary(estimation, out, time.monotonic() - begin), as_json)


def _prepare(
    source: Path, out: Path, name: str, contacts: list[str], support: str | None
) -> tuple["Estimation", list]:
    """Read everything; what the user got wrong is a UsageError."""
    from deploy.contacts import read_touch, support_of
    from deploy.estimate.reading import read_input
    from deploy.estimate.run import Estimation
    from robot_model import DescriptionError, load_robot

    if not out.parent.is_dir():
        raise CommandError(f"cannot write {out}: there is no folder {out.parent}")
    if out.exists() and source.exists() and out.samefile(source):
        raise UsageError(f"{out} is the input; expected another file for the output")
    touches = [read_touch(text) for text in contacts]
    try:
        robot = load_robot(name)
    except DescriptionError as error:
        raise UsageError(str(error)) from None
    given = read_input(source, robot)
    estimation = Estimation(given, support_of(robot, support), touches)
    for text in given.warnings + estimation.warnings:
        print_warning(text)
    return estimation, touches


def _run(estimation: "Estimation") -> None:
    from deploy.progress import ProgressBar

    bar = ProgressBar(len(estimation.log), estimation.log.period)
    try:
        estimation.run(bar.show)
    finally:
        bar.end()


def _summary(estimation: "Estimation", out: Path, elapsed: float) -> dict[str, Any]:
    found, stamp = estimation.found, estimation.log.stamp
    duration = float(stamp[-1] - stamp[0]) * 1e-9
    return {
        "file": str(out),
        "samples": len(stamp),
        "duration_s": duration,
        "elapsed_s": elapsed,
        "valid_torques": float(found.torque_valid.mean()),
        "valid_wrenches": float(found.wrench_valid.mean()),
        "contacts": [contact.frame for contact in estimation.observer.contacts],
    }


def _tell(summary: dict[str, Any], as_json: bool) -> None:
    if as_json:
        print_json(summary)
        return
    seconds, took = summary["duration_s"], summary["elapsed_s"]
    print_line(f"written: {summary['file']}: {summary['samples']} samples, {seconds:.3f} s"
               f" in {took:.1f} s")  # fmt: skip
    torques, wrenches = 100.0 * summary["valid_torques"], 100.0 * summary["valid_wrenches"]
    print_line(f"valid: torques {torques:.4g} %, wrenches {wrenches:.4g} %")
