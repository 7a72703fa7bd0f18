"""``wrenchbus calibrate``: what the contact detector learns from a robot that nothing touches."""

from collections.abc import Iterator
from contextlib import contextmanager
from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deploy.options import Json, Robot, at_most_one, on_the_bus
from deploy.output import print_json, print_message, print_warning

if TYPE_CHECKING:
    from bus import Node

DETECTOR = "/contact_detector/rpc:i"
SLOWEST, SOON = 5.0, 10.0  # times; s. The seconds are the robot's, in slow motion they last longer


class What(StrEnum):
    """What can be calibrated."""

    contacts = "contacts"


@on_the_bus
def calibrate(
    node: "Node",
    what: Annotated[What, typer.Argument(help="What to calibrate.")],
    seconds: Annotated[
        float, typer.Option(min=0.1, max=120.0, help="How long to record the moving robot.")
    ] = 30.0,
    quiet: Annotated[
        float, typer.Option(min=0.0, max=120.0, help="How long it rests before; 0: not at all.")
    ] = 2.0,
    motion: Annotated[
        str, typer.Option(metavar="NAME", help="Motion that the simulated robot makes meanwhile.")
    ] = "",
    listed: Annotated[bool, typer.Option("--list", help="List the stored calibrations.")] = False,
    use: Annotated[
        str, typer.Option(metavar="DATE", help="Put a stored one in force; none: no calibration.")
    ] = "",
    forget: Annotated[str, typer.Option(metavar="DATE", help="Remove a stored one.")] = "",
    robot: Robot = None,
    as_json: Json = False,
) -> None:
    """Learn how much motion alone disturbs the contact detector.

    Nothing but the supports may touch the robot. It rests first, then moves as it will in
    use; deviations of single sensors and joints, and thresholds, are raised to what that
    shows, kept for this robot and support, and in force again when the detector restarts.
    """
    at_most_one({"--list": listed, "--use": use, "--forget": forget})
    if listed:
        answer = node.call(DETECTOR, "calibrations", {}, timeout=5.0)
    elif use or forget:
        verb = "use_calibration" if use else "forget_calibration"
        answer = node.call(DETECTOR, verb, {"date": use or forget}, timeout=5.0)
    else:
        answer = _record(node, seconds, quiet, motion, robot)
    if as_json:
        print_json(answer)
    else:
        print_message(answer)


def _record(
    node: "Node", seconds: float, quiet: float, motion: str, robot: str | None
) -> dict[str, Any]:
    if quiet:
        node.call(DETECTOR, "tare", {"seconds": quiet}, timeout=SLOWEST * quiet + SOON)
    with _moving(node, motion, robot):
        if not motion:
            print_warning(f"now move the robot for {seconds:g} s, and touch it nowhere")
        return node.call(
            DETECTOR, "calibrate", {"seconds": seconds}, timeout=SLOWEST * seconds + SOON
        )


@contextmanager
def _moving(node: "Node", motion: str, robot: str | None) -> Iterator[None]:
    """Let the simulated robot move, if it is asked to."""
    if not motion:
        yield
        return
    from deploy.discovery import simulator_port

    port = simulator_port(node, robot)
    node.call(port, "motion", {"name": motion}, timeout=5.0)
    try:
        yield
    finally:
        node.call(port, "motion", {"name": "stop"}, timeout=5.0)
