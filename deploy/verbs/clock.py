"""``wrenchbus clock``: the simulated time."""

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deploy.errors import CommandError
from deploy.options import Json, Robot, on_the_bus
from deploy.output import print_json, print_line, print_table

if TYPE_CHECKING:
    from bus import Node

MEASURE = 1.0  # [s]


class Action(StrEnum):
    """What to do with the clock."""

    show = "show"
    pause = "pause"
    resume = "resume"
    step = "step"


@on_the_bus
def clock(
    node: "Node",
    action: Annotated[Action, typer.Argument(help="What to do.")] = Action.show,
    ticks: Annotated[int, typer.Option("-n", "--ticks", min=1, help="Of step [1 ms].")] = 1,
    robot: Robot = None,
    as_json: Json = False,
) -> None:
    """Show time, state and rate of the clocks on the bus; pause, resume or step the simulator.

    The rate is that of simulated to wall time.
    """
    if action is not Action.show:
        _ask(node, action.value, ticks, robot, as_json)
        return
    from deploy.clocks import look_at_clocks

    rows = look_at_clocks(node, MEASURE)
    if not rows:
        raise CommandError("no clock on this bus: nothing is simulated, all time is wall time")
    if as_json:
        print_json(rows)
    else:
        print_table([_row(row) for row in rows], ["port", "time [s]", "state", "rate"])


def _ask(node: "Node", verb: str, ticks: int, robot: str | None, as_json: bool) -> None:
    from deploy.discovery import simulator_port

    request = {"ticks": ticks} if verb == "step" else {}
    answer = node.call(simulator_port(node, robot), verb, request, timeout=5.0 + 0.05 * ticks)
    if as_json:
        print_json(answer)
    else:
        print_line(f"{verb}: the clock is at {1e-9 * answer['time']:.3f} s")


def _row(row: dict[str, Any]) -> dict[str, Any]:
    return row | {"time [s]": None if row["time"] is None else f"{1e-9 * row['time']:.3f}"}
