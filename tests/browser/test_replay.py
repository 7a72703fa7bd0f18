"""The page while a recording is played."""

import pytest

from bus import Node
from bus.testing import Process, eventually
from tests.system.lockstep_runs import REFERENCE

pytestmark = [pytest.mark.browser, pytest.mark.system, pytest.mark.timeout(600)]


def test_the_page_says_replay_and_pauses_and_moves_the_recording(start, hub, look):
    start("dashboard")
    player = Process("deploy.main", "play", str(REFERENCE), "--loop", "--rate", "2", "-e", hub)
    try:
        with Node("asker", connect=hub, signals=False) as asker:
            page = look(asker.call("/dashboard/rpc:i", "status")["url"])
            page.await_text("status", r"^replay t = [0-9.]+ s$")
            page.page.get_by_text("Log [s]", exact=True).wait_for()
            page.press("Pause")
            page.await_text("result", "^pause: the recording is at ")
            page.await_text("status", "^paused t = ")

            def position() -> float:
                return asker.call("/player/rpc:i", "status")["position"]

            label = page.page.get_by_text("Log [s]", exact=True)
            field = label.locator("xpath=following::input[@type='text'][1]")

            def sought() -> bool:  # the page may renew the field while somebody types
                field.fill("1.5")
                field.press("Enter")
                page.page.wait_for_timeout(1000)
                return 1.5 <= position() < 1.6

            eventually(sought, 90.0)
            page.press("Resume")
            page.await_text("status", "^replay")
    finally:
        player.stop()
        player.clean_up()
