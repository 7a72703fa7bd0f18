"""The page of a whole simulated robot: every service is the real one."""

import pytest

from dashboard.chromium import choose
from robot_model import load_robot
from tests.system.stack import Stack

pytestmark = [pytest.mark.browser, pytest.mark.system, pytest.mark.timeout(900)]

# slow motion: a browser that draws in software leaves little to the services
PLANT = ("--set", "profile=ideal", "--set", "scenario=quiet", "--set", "speed=0.2")
PAGE = ("--set", "push_duration=1.5", "--set", "scene_rate=5")  # simulated s, Hz
LEFT_FOREARM = r"^contact: l_forearm [0-9.]+ N p=[01]\.\d\d$"


@pytest.fixture
def stack():
    with Stack(load_robot("icub"), {"robot_sim": PLANT, "dashboard": PAGE}) as running:
        running.await_whole()
        yield running


def test_a_push_is_a_contact_there_and_tare_pause_and_stop_are_heard(stack, look):
    page = look(stack.node.call("/dashboard/rpc:i", "status")["url"])
    page.await_text("status", r"^live t = [0-9.]+ s$")
    page.await_text("alarm", "^no contact$")
    choose(page.page, "Link", "l_forearm")
    page.press("Push")
    page.await_text("alarm", LEFT_FOREARM)
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
