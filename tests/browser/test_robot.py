"""The page of a whole simulated robot: every service is the real one.

Pushes, by the button and by a click on the robot, are felt where they act.
"""

from collections.abc import Iterator

import numpy as np
import pytest

from bus import Input
from dashboard.chromium import choose
from dashboard.placement import Placement
from robot_model import Robot, load_robot
from robot_model.messages import Contacts
from tests.system.stack import Stack

pytestmark = [pytest.mark.browser, pytest.mark.system, pytest.mark.timeout(900)]

# slow motion: a browser that draws in software leaves little to the services
PLANT = ("--set", "profile=ideal", "--set", "scenario=quiet", "--set", "speed=0.2")
LINK = "l_forearm"
TOUCHED = r"^contact: l_forearm [0-9.]+ N p=[01]\.\d\d$"
CLOSE = 0.03  # [m]
DISTANCE = 0.5  # [m] of the camera from the forearm


@pytest.fixture(scope="module")
def robot() -> Robot:
    return load_robot("icub")


@pytest.fixture(scope="module")
def stack(robot: Robot) -> Iterator[Stack]:
    """A robot whose page looks straight at the left forearm, from outside."""
    target, outward = forearm(robot)
    settings = {
        "camera_look_at": target.tolist(),
        "camera_offset": (target + DISTANCE * outward).tolist(),
        "push_duration": 4.0,  # simulated s
        "scene_rate": 5,  # Hz
    }
    page = [text for item in settings.items() for text in ("--set", "{}={}".format(*item))]
    with Stack(robot, {"robot_sim": PLANT, "dashboard": page}) as running:
        running.await_whole()
        yield running


def forearm(robot: Robot) -> tuple[np.ndarray, np.ndarray]:
    """Return the middle of the forearm's exposed surface and the way out of it, base axes."""
    placement = Placement(robot)
    placement.update(robot.home, np.zeros(3), np.array([1.0, 0.0, 0.0, 0.0]))
    surface = robot.load_surface()
    body = [body.name for body in surface.bodies].index(LINK)
    own = surface.body == body
    middle = placement.point(LINK, surface.points[own].mean(axis=0))
    return middle, np.array([0.0, np.sign(middle[1]), 0.0])


@pytest.fixture(scope="module")
def opened(stack: Stack, look_on):
    return look_on(stack.node.call("/dashboard/rpc:i", "status")["url"])


@pytest.fixture
def page(stack: Stack, opened):
    """The page of a robot that nothing touches."""
    stack.simulate("release")  # what an earlier test has pushed
    opened.await_text("status", r"^live t = [0-9.]+ s$")
    opened.await_text("alarm", "^no contact$")
    return opened


def test_a_click_on_the_left_forearm_is_a_contact_there_within_3_cm(stack, page):
    truths = stack.listen("truth")
    page.click_scene(0.5, 0.5)
    page.await_text("result", f"^push 15 N on {LINK} where it was clicked: ")
    point = np.array(stack.until(lambda: _push(truths), lambda: "no push on the forearm"))
    seen: list[float] = []
    stack.until(
        lambda: _is_close(stack.newest("contacts"), point, seen),
        lambda: f"errors of the place [m]: {seen[-9:]}",
    )
    page.await_text("last", f"^last contact: {LINK} ")


def test_a_push_is_a_contact_there_and_tare_pause_and_stop_are_heard(stack, page):
    choose(page.page, "Link", LINK)
    page.press("Push")
    page.await_text("alarm", TOUCHED)
    stack.simulate("release")  # sooner than by itself
    page.await_text("alarm", "^no contact$")
    page.await_text("last", "^last contact: l_")

    page.press("Tare")
    page.await_text("result", "^tare (torque_observer|contact_detector): ")

    page.press("Pause")
    page.await_text("status", "^paused")
    page.press("Resume")
    page.await_text("status", "^live")

    page.press("Stop")
    page.await_text("status", "stopped")
    page.press("Release")
    page.await_text("status", r"^live t = [0-9.]+ s$")


def _push(truths: Input) -> list[float] | None:
    """Return where the forearm is pushed, link frame [m]."""
    truths.newest()
    pushes = truths.latest.data.pushes if truths.latest else []
    return next((push["point"] for push in pushes if push["link"] == LINK), None)


def _is_close(contacts: Contacts, point: np.ndarray, seen: list[float]) -> bool:
    best = next(iter(contacts.hypotheses), None)
    if best is None or best["links"][0] != LINK:
        return False
    seen.append(float(np.linalg.norm(np.array(best["point"]) - point)))
    return seen[-1] < CLOSE
