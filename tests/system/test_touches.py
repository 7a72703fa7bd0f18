"""Over the bus: the wrench of a touch is told where it acts, when it begins, moves and ends."""

from collections.abc import Iterator

import numpy as np
import pytest

from bus import Input
from robot_model import Robot, ports
from robot_model.messages import ExternalWrenches
from tests.system.stack import Stack

pytestmark = [pytest.mark.system, pytest.mark.timeout(300)]
FORCE = 12.0  # N
SOON = 300_000_000  # ns from the beginning of a push to a wrench that is right
UNUSED = ("dashboard", "base_estimator", "gravity_compensator")
IN_LOCKSTEP = ("sensor_server", "torque_observer", "contact_detector")  # so nobody is late


@pytest.fixture(scope="module")
def touched_stack(robot: Robot) -> Iterator[Stack]:
    """A standing robot whose observer follows the touches that the detector finds."""
    lockstep = ("--set", "lockstep=true")
    settings = {name: lockstep for name in IN_LOCKSTEP}
    settings["robot_sim"] = (*lockstep, "--set", f"participants=[{', '.join(IN_LOCKSTEP)}]")
    settings["torque_observer"] = (*lockstep, "--set", "follow_touches=true")
    with Stack(robot, settings, without=UNUSED) as stack:
        stack.until(lambda: stack.state("contacts") == "valid", lambda: stack.state("contacts"))
        yield stack


def spot(robot: Robot, link: str) -> tuple[np.ndarray, np.ndarray]:
    """Return a point of a link's surface and its inward normal, both (3,) in its frame."""
    surface = robot.load_surface()
    mine = np.flatnonzero(surface.body == [body.name for body in surface.bodies].index(link))
    index = mine[len(mine) // 3]
    return surface.points[index], -surface.normals[index]


def push(stack: Stack, link: str) -> dict[str, int]:
    point, inward = spot(stack.robot, link)
    force = (FORCE * inward).tolist()
    return stack.simulate("push", link=link, point=point.tolist(), force=force, profile="hold")


def listen(stack: Stack) -> Input:
    robot = stack.robot
    return stack.node.input(
        "/observer/touches:i",
        ExternalWrenches,
        source=ports.name("wrenches", robot),
        depth=3000,
        model=robot.model_hash,
        dimensions=robot.dimensions,
    )


def first_right(stack: Stack, wrenches: Input, link: str) -> int:
    """Return the stamp of the first wrench that is right in place and force."""
    point, inward = spot(stack.robot, link)
    lasts = ""

    def look() -> int | None:
        nonlocal lasts
        while (received := wrenches.read()) is not None:
            data = received.data
            row = data.subtree.index("l_arm")
            lasts = f"{data.link[row]} {data.kind[row]} {data.point[row]} {data.wrench[row]}"
            placed = data.kind[row] == "touch" and data.link[row] == link
            if not (received.envelope.valid and placed):
                continue
            near = np.abs(data.point[row] - point).max() < 0.015
            if near and np.abs(data.wrench[row, :3] - FORCE * inward).max() < 0.5:
                assert np.abs(data.wrench[row, 3:]).max() < 1e-6  # a pure force
                return received.envelope.stamp
        return None

    return stack.until(look, lambda: f"no right wrench on {link}; last: {lasts}")


def test_a_push_away_from_the_default_contact_has_the_right_wrench_wherever_it_moves(
    touched_stack: Stack,
) -> None:
    stack = touched_stack
    wrenches = listen(stack)
    for link in ("l_forearm", "l_upper_arm"):  # a change of place without a pause
        stack.simulate("release")
        begun = push(stack, link)["start_stamp"]
        assert first_right(stack, wrenches, link) - begun <= SOON
    stack.simulate("release")
    arm = stack.robot.subtree_of("l_forearm")

    def is_default() -> bool:
        received = wrenches.newest()
        return received is not None and received.data.kind[arm] == "default"

    stack.until(is_default, lambda: "the touch does not end")
