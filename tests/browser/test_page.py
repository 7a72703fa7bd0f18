"""The page by itself: a feeder plays the services."""

from collections.abc import Iterator

import pytest

from bus import Node
from bus.testing import Process, running_hub, wait_for_service
from dashboard.chromium import choose

pytestmark = [pytest.mark.browser, pytest.mark.system, pytest.mark.timeout(600)]


class Fed:
    """A page, and a feeder that plays the services."""

    def __init__(self, hub: str):
        self._hub = hub
        self.processes = [Process("dashboard", "--connect", hub)]
        self.feed()

    def feed(self) -> None:
        """Start the feeder."""
        self.feeder = Process("tests.dashboard.feeder", "--connect", self._hub)
        self.processes.append(self.feeder)

    def url(self) -> str:
        """Return the page's address."""
        with Node("reader", connect=self._hub, signals=False) as reader:
            wait_for_service(reader, "dashboard", timeout=60.0)
            return reader.call("/dashboard/rpc:i", "status")["url"]


@pytest.fixture(scope="module")
def fed() -> Iterator[Fed]:
    with running_hub() as hub:
        running = Fed(hub)
        try:
            yield running
            for process in running.processes:
                assert process.stop() == 0 or process.expected is None  # killed
        finally:
            for process in running.processes:
                process.clean_up()


@pytest.fixture(scope="module")
def opened(fed: Fed, look_on):
    return look_on(fed.url())


@pytest.fixture
def page(opened):
    opened.open_tab("Live")
    return opened


def test_page_shows_state_and_contact_and_its_buttons_work(page):
    page.await_text("status", "^live")
    page.await_text("alarm", "^no contact$")

    choose(page.page, "Link", "l_forearm")
    page.press("Push")
    page.await_text("last", r"^last contact: l_forearm 15\.0 N p=0\.90, \d+ s ago$")
    page.await_text("strip", r"l_arm\s+(contact 12\.0|none 1\.5) / 6\.5")
    page.await_text("result", "^push 15 N ")

    page.await_text("wrenches", r"l_sole\s*\d+\.\d\s*\d+\.\d\s*\d+\.\d\d\s*\d+\.\d\d")

    page.press("Tare")
    page.await_text("result", "^tare contact_detector: tare refused: the robot moves")
    page.await_text("offsets", r"l_arm_ft\s*1\.2 -0\.5 2\.0")

    page.press("Pause")
    page.await_text("status", "^paused")
    page.press("Resume")
    page.await_text("status", "^live")

    page.press("Record")
    page.await_text("recording", r"^recording walk\.mcap, 12\.3 MB, 1:34, 0 lost$")
    page.press("Finish recording")
    page.await_text("recording", r"^recorded walk\.mcap, ")

    page.press("Stop")
    page.await_text("status", "stopped")
    page.press("Release")
    page.await_text("status", "^live t = [0-9.]+ s$")


def test_thresholds_are_tuned_reset_and_saved(page):
    page.open_tab("Tune")
    page.page.get_by_text("Contact [std]", exact=True).wait_for()
    field = page.page.locator(".mantine-NumberInput-input:visible").first
    field.fill("9")
    page.await_text("tuning", r"^levels\.contact = 9(\.0)?$")
    page.press("Reset settings")
    page.await_text("tuning", "^reset to the detector's configuration$")
    page.page.wait_for_function("([f]) => f.value === '6.5'", arg=[field.element_handle()])
    page.press("Save settings")
    page.await_text("tuning", r"^saved in /state/x\.yaml$")


def test_ports_and_help_are_one_click_away(page):
    page.open_tab("Ports")
    page.await_text("ports", "/icub/sensors:o")
    page.open_tab("Help")
    page.page.get_by_text("estimated wrench of a touch").wait_for()
    page.open_tab("Live")
    page.page.get_by_role("button", name="Push", exact=True).wait_for()


def test_silence_looks_stale_and_passes(fed: Fed, page):
    page.await_text("status", "^live")
    fed.feeder.kill()
    page.await_text("status", "^stale: no data on /icub/sensors:o for ")
    page.await_text("alarm", "^contact unknown: ")
    fed.feed()
    page.await_text("status", "^live")
