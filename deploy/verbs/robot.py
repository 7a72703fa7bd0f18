"""``wrenchbus push``, ``tare``, ``stop``: what is done to the robot and its services."""

from enum import StrEnum
from typing import TYPE_CHECKING, Annotated, Any

import typer

from deploy.errors import CommandError
from deploy.options import Json, Robot, at_most_one, checked_vector, on_the_bus, vector
from deploy.output import print_json, print_line, print_message

if TYPE_CHECKING:
    from bus import Node

TARED = ("torque_observer", "contact_detector")
SLOWEST, SOON = 5.0, 5.0  # times; s. The seconds are the robot's, in slow motion they last longer


class Frame(StrEnum):
    """Axes of a force."""

    link = "link"
    world = "world"


class Profile(StrEnum):
    """Force over time."""

    hold = "hold"
    ramp = "ramp"
    half_sine = "half_sine"


@on_the_bus
def push(
    node: "Node",
    link: Annotated[str, typer.Argument(help="Link that is pushed, as l_forearm.")],
    force: Annotated[
        str, typer.Option(metavar="X,Y,Z", callback=checked_vector, help="Force [N].")
    ],
    point: Annotated[
        str,
        typer.Option(metavar="X,Y,Z", callback=checked_vector, help="In the link's frame [m]."),
    ] = "0,0,0",
    frame: Annotated[Frame, typer.Option(help="Axes of the force.")] = Frame.link,
    profile: Annotated[Profile, typer.Option(help="Force over time.")] = Profile.hold,
    duration: Annotated[float, typer.Option(min=0.001, help="Seconds.")] = 1.0,
    robot: Robot = None,
    as_json: Json = False,
) -> None:
    """Push the simulated robot."""
    from deploy.discovery import simulator_port

    request = {
        "link": link,
        "point": list(vector(point)),
        "force": list(vector(force)),
        "frame": frame.value,
        "profile": profile.value,
        "duration": duration,
    }
    answer = node.call(simulator_port(node, robot), "push", request, timeout=5.0)
    if as_json:
        print_json(answer)
    else:
        print_line(f"push {answer['push_id']} on {link} from {answer['start_stamp']} ns")


@on_the_bus
def tare(
    node: "Node",
    seconds: Annotated[float, typer.Option(min=0.1, help="How long to average.")] = 1.0,
    stance: Annotated[
        str, typer.Option(help="What bears the robot: pole, floor, l_sole; its support if unsaid.")
    ] = "",
    listed: Annotated[bool, typer.Option("--list", help="List the stored offsets.")] = False,
    use: Annotated[
        str, typer.Option(metavar="DATE", help="Put stored offsets in force; a beginning will do.")
    ] = "",
    revert: Annotated[bool, typer.Option("--revert", help="Undo the last tare or --use.")] = False,
    as_json: Json = False,
) -> None:
    """Tare the force/torque sensors.

    The robot must stand still, touched by nothing but its supports. --list, --use and
    --revert concern the torque observer, which stores what its tares find.
    """
    at_most_one({"--list": listed, "--use": use, "--revert": revert})
    if listed or use or revert:
        verb = "tares" if listed else "use_tare" if use else "revert_tare"
        answers = _ask(node, {"torque_observer": {"date": use} if use else {}}, verb, 5.0)
    else:
        requests: dict[str, dict[str, Any]] = {name: {"seconds": seconds} for name in TARED}
        if stance:
            requests["torque_observer"]["stance"] = stance
        answers = _ask(node, requests, "tare", SLOWEST * seconds + SOON)
    if as_json:
        print_json(answers)
    else:
        for service, answer in answers.items():
            print_message(answer, service)


def _ask(
    node: "Node", requests: dict[str, dict[str, Any]], verb: str, timeout: float
) -> dict[str, Any]:
    """Return the answers of those services that run."""
    from bus import RpcAbsent

    answers: dict[str, Any] = {}
    for service, request in requests.items():
        try:
            answers[service] = node.call(f"/{service}/rpc:i", verb, request, timeout=timeout)
        except RpcAbsent:
            continue
    if not answers:
        raise CommandError(f"nobody to tare: {' or '.join(requests)} must run")
    return answers


@on_the_bus
def stop(
    node: "Node",
    release: Annotated[bool, typer.Option("--release", help="End the stop.")] = False,
    as_json: Json = False,
) -> None:
    """Stop the robot, or end the stop.

    A stopped robot holds its posture and refuses commands until --release.
    """
    answer = node.call("/sensor_server/rpc:i", "release" if release else "stop", {}, timeout=2.0)
    if as_json:
        print_json(answer)
    else:
        print_line("commands are accepted again" if release else "stopped: holding the posture")
