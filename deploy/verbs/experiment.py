"""``wrenchbus experiment``: an experiment of the papers, in simulation and without a bus."""

from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deploy.errors import CommandError, UsageError
from deploy.options import Description
from deploy.output import print_json, print_line
from deploy.progress import bar
from deploy.terminal import clear, draw

if TYPE_CHECKING:
    from experiments.report import Report

Names = list[str] | None
Name = Annotated[
    str,
    typer.Argument(
        metavar="NAME",
        help="coverage, external_wrench, ft_prediction, kinematic_sources, residuals or touch.",
    ),
]
Seed = Annotated[int, typer.Option(min=0, help="Equal seeds give equal results.")]
Runs = Annotated[
    int | None, typer.Option(min=0, help="How many runs, or pushes; default: its own.")
]
Document = Annotated[bool, typer.Option("--json", help="Print one JSON document.")]
Folder = Annotated[
    Path | None,
    typer.Option("-o", "--output", metavar="DIR", help="Folder for tables and figures."),
]
Physics = Annotated[
    str | None, typer.Option(help="touch: mujoco or pinocchio; default: MuJoCo if installed.")
]
Profiles = Annotated[Names, typer.Option(help="touch: noise profile; repeatable; default: drawn.")]
Variants = Annotated[
    Names,
    typer.Option(
        help="touch: usual, exact_masses, untared, friction, gain, calibrated, "
        "exact_masses_calibrated, friction_calibrated, gain_calibrated, apart or together; "
        "repeatable; default: drawn."
    ),
]
Methods = Annotated[Names, typer.Option(help="touch: surface, line or particle; repeatable.")]
Hours = Annotated[
    float | None, typer.Option(min=0.0, help="touch: hours of contact-free motion as well.")
]
Jobs = Annotated[int | None, typer.Option(min=1, help="touch: processes side by side.")]
Index = Annotated[
    int | None,
    typer.Option("--draw", min=0, help="touch: repeat the run of this index, with a picture."),
]


def experiment(
    name: Name,
    robot: Description = "icub",
    seed: Seed = 1,
    runs: Runs = None,
    json: Document = False,
    output: Folder = None,
    physics: Physics = None,
    profile: Profiles = None,
    variant: Variants = None,
    method: Methods = None,
    hours: Hours = None,
    jobs: Jobs = None,
    index: Index = None,
) -> None:
    """Repeat an experiment of the papers in simulation; prints how far estimates are off.

    ft_prediction: model against measured F/T readings while the limbs move.
    external_wrench: known wrenches at a hand, and the torques that they make.
    kinematic_sources: one inertial sensor, all fused, a fixed link (--robot icub_inertial).
    coverage: how often the stated intervals hold the truth.
    residuals: classical, internal and external residuals, forces at points, the line.
    touch: the benchmark of the contact detector. With -o it goes on where it was interrupted,
    and reports all results in the folder.
    """
    given = {
        "physics": physics,
        "profiles": profile,
        "variants": variant,
        "methods": method,
        "hours": hours,
        "jobs": jobs,
        "draw": index,
    }
    options = {key: value for key, value in given.items() if value not in (None, [])}
    report = _run(name, robot, seed, runs, options, output)
    written = _write(report, output)
    if json:
        print_json(report.document)
        return
    for line in report.lines + [f"wrote {path}" for path in written]:
        print_line(line)


def _run(
    name: str,
    robot: str,
    seed: int,
    runs: int | None,
    options: dict[str, Any],
    output: Path | None,
) -> "Report":
    """Return the report; what the user got wrong is a UsageError."""
    from experiments.catalogue import require, run_experiment
    from robot_model import DescriptionError, load_robot

    if runs == 0 and not options.get("hours"):
        raise UsageError("--runs 0 leaves nothing to do; touch takes --hours of free motion")
    try:
        if require(name) == "touch":
            options = options | {"folder": output, "progress": _show}
        return run_experiment(name, load_robot(robot), seed, runs, **options)
    except (DescriptionError, LookupError, ValueError) as error:
        raise UsageError(str(error)) from None
    finally:
        clear()


def _show(done: int, of: int) -> None:
    draw(f"{bar(done / of)} {done} of {of} runs")


def _write(report: "Report", folder: Path | None) -> list[Path]:
    try:
        return [] if folder is None else report.write(folder)
    except OSError as error:
        raise CommandError(f"cannot write into {folder}: {error.strerror}") from None
