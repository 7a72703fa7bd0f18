"""``wrenchbus experiment``: an experiment of the papers, in simulation and without a bus."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from deploy.errors import CommandError, UsageError
from deploy.output import print_json, print_line

if TYPE_CHECKING:
    from experiments.report import Report


def experiment(
    name: Annotated[
        str,
        typer.Argument(
            metavar="NAME",
            help="coverage, external_wrench, ft_prediction, kinematic_sources or touch.",
        ),
    ],
    robot: Annotated[str, typer.Option(help="Robot name, or its description file.")] = "icub",
    seed: Annotated[int, typer.Option(min=0, help="Equal seeds give equal results.")] = 1,
    runs: Annotated[
        int | None, typer.Option(min=1, help="How many runs, or pushes; default: its own.")
    ] = None,
    json: Annotated[bool, typer.Option("--json", help="Print one JSON document.")] = False,
    output: Annotated[
        Path | None,
        typer.Option("-o", "--output", metavar="DIR", help="Folder for tables and figures."),
    ] = None,
) -> None:
    """Repeat an experiment of the papers in simulation; prints how far estimates are off.

    ft_prediction: model against measured F/T readings while the limbs move.
    external_wrench: known wrenches at a hand, and the torques that they make.
    kinematic_sources: one inertial sensor, all fused, a fixed link (--robot icub_inertial).
    coverage: how often the stated intervals hold the truth.
    touch: pushes at random places, found by the contact detector.
    """
    report = _run(name, robot, seed, runs)
    written = _write(report, output)
    if json:
        print_json(report.document)
        return
    for line in report.lines + [f"wrote {path}" for path in written]:
        print_line(line)


def _run(name: str, robot: str, seed: int, runs: int | None) -> "Report":
    """Return the report; what the user got wrong is a UsageError."""
    from experiments.catalogue import require, run_experiment
    from robot_model import DescriptionError, load_robot

    try:
        require(name)
        return run_experiment(name, load_robot(robot), seed, runs)
    except (DescriptionError, LookupError, ValueError) as error:
        raise UsageError(str(error)) from None


def _write(report: "Report", folder: Path | None) -> list[Path]:
    try:
        return [] if folder is None else report.write(folder)
    except OSError as error:
        raise CommandError(f"cannot write into {folder}: {error.strerror}") from None
