"""``wrenchbus wrench``: any wrench of the last sample, with its uncertainty."""

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deploy.options import Json, checked_vector, on_the_bus, vector
from deploy.output import print_json, print_line

if TYPE_CHECKING:
    from bus import Node


@on_the_bus
def wrench(
    node: "Node",
    of: Annotated[
        str,
        typer.Argument(
            metavar="KIND:NAME", help="contact, subtree, sensor, joint or link, and its name."
        ),
    ],
    frame: Annotated[
        str, typer.Option(help="Link or frame about whose origin it is told; default: its own.")
    ] = "",
    axes: Annotated[
        str, typer.Option(help="Link or frame in whose axes it is told; default: the same.")
    ] = "",
    point: Annotated[
        str,
        typer.Option(
            metavar="X,Y,Z", callback=checked_vector, help="In the frame, not its origin [m]."
        ),
    ] = "0,0,0",
    as_json: Json = False,
) -> None:
    """Tell any wrench of the last sample: one standard deviation stands behind each ±.

    The deviations and the covariance (--json) come from the noise that the torque observer
    is told of.
    """
    request = {"of": of, "frame": frame, "axes": axes, "point": list(vector(point))}
    answer = node.call("/torque_observer/rpc:i", "wrench", request, timeout=5.0)
    if as_json:
        print_json(answer)
    else:
        for line in _lines(answer):
            print_line(line)


def _lines(answer: dict[str, Any]) -> Iterator[str]:
    """The lines for people; what is invalid or undecided is always marked so."""
    std = [max(row[i], 0.0) ** 0.5 for i, row in enumerate(answer["covariance"])]
    point = ", ".join(f"{x:g}" for x in answer["point"])
    yield f"{answer['of']} about ({point}) m in {answer['frame']}, axes of {answer['axes']}"
    if not answer["valid"]:
        yield f"INVALID: {answer['reason']}"
    yield f"  force [N]: {_with_std(answer['force'], std[:3], 2)}"
    yield f"  moment [N m]: {_with_std(answer['moment'], std[3:], 3)}"
    if answer["undecided"]:
        yield "UNDECIDED: this is the smallest that explains the sensors, and ± is of it alone."
        yield "Any multiple may be added of [fx fy fz mx my mz]:"
    for pattern in answer["undecided"]:
        yield f"  {'  '.join(f'{value:.3f}' for value in pattern)}"


def _with_std(values: Sequence[float], std: Sequence[float], digits: int) -> str:
    pairs = zip(values, std, strict=True)
    return "  ".join(f"{value:.{digits}f} ± {spread:.{digits}f}" for value, spread in pairs)
