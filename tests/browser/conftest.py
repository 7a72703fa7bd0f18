"""A browser for the tests of this folder."""

from collections.abc import Iterator
from pathlib import Path

import pytest
from playwright.sync_api import Browser
from playwright.sync_api import TimeoutError as NotInTime

from dashboard.chromium import open_browser, show

SETTLE = 3000  # [ms] for a camera that moves to where it shall stand
SIZE = (800, 600)  # [px]; small, because everything is drawn in software


@pytest.fixture(scope="session")
def browser() -> Iterator[Browser]:
    with open_browser() as opened:
        yield opened


@pytest.fixture(scope="session")
def screenshots(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Where pictures for whoever looks after a failure are put."""
    return tmp_path_factory.mktemp("screenshots")


class Looked:
    """A page that is open in the browser, and what went wrong in it."""

    def __init__(self, browser: Browser, url: str):
        self.errors: list[str] = []
        self.page = show(browser, url, *SIZE, on_error=self.errors.append)

    def text(self, identifier: str) -> str:
        """Return the text of one of the page's lines."""
        return self.page.locator(f"#{identifier}").inner_text()

    def press(self, label: str) -> None:
        """Press a button."""
        self.page.get_by_role("button", name=label, exact=True).click()

    def click_scene(self, right: float, down: float) -> None:
        """Click into the scene, at parts of its width and height."""
        self.page.wait_for_timeout(SETTLE)
        box = self.page.locator("canvas").first.bounding_box()
        assert box is not None
        x, y = box["x"] + right * box["width"], box["y"] + down * box["height"]
        self.page.mouse.click(x, y)

    def open_tab(self, label: str) -> None:
        """Turn to a tab."""
        self.page.get_by_role("tab", name=label, exact=True).click()

    def await_text(self, identifier: str, pattern: str) -> None:
        """Wait until a line matches a regular expression; say what it reads when it does not."""
        test = "([id, pattern]) => new RegExp(pattern).test(document.getElementById(id)?.innerText)"
        try:
            self.page.wait_for_function(test, arg=[identifier, pattern], polling=100)
        except NotInTime:
            pytest.fail(f"{identifier}: expected {pattern!r}, reads {self.text(identifier)!r}")


def _look(browser: Browser, screenshots: Path, request: pytest.FixtureRequest) -> Iterator:
    """Return ``look(url)``, which opens a page; its picture is kept, its errors fail the test."""
    opened: list[Looked] = []

    def open_page(url: str) -> Looked:
        opened.append(Looked(browser, url))
        return opened[-1]

    yield open_page
    for i, looked in enumerate(opened):
        looked.page.screenshot(path=screenshots / f"{Path(request.node.name).stem}-{i}.png")
        looked.page.close()
        assert not looked.errors


look = pytest.fixture(_look)
look_on = pytest.fixture(_look, scope="module")  # opening is slow: one page for several tests
