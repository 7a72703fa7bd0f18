"""A headless Chromium that shows the page, also where there is no GPU."""

import os
import shutil
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from playwright.sync_api import Browser, Page

NAMES = ("chromium", "chromium-browser", "google-chrome", "google-chrome-stable", "chrome")
FLAGS = (
    "--no-sandbox",
    "--disable-quic",
    "--no-first-run",
    "--disable-background-networking",
    "--disable-component-update",
    "--disable-sync",
    "--use-gl=angle",
    "--use-angle=swiftshader",
    "--enable-unsafe-swiftshader",
)
PATIENCE = 150_000  # [ms]; drawing in software on a busy machine is slow


def find_chromium() -> str:
    """Return the path of a Chromium: $CHROMIUM, or the first known name on the path.

    Raises:
        FileNotFoundError: There is none.
    """
    candidates = (os.environ.get("CHROMIUM", ""), *NAMES)
    found = next((path for name in candidates if (path := shutil.which(name))), None)
    if found is None:
        raise FileNotFoundError(
            f"no Chromium found; expected $CHROMIUM or one of {', '.join(NAMES)} on the path:"
            " install it, for example by 'apt-get install chromium'"
        )
    return found


@contextmanager
def open_browser() -> Iterator["Browser"]:
    """Start Chromium; it ends with the block."""
    from playwright.sync_api import sync_playwright

    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(executable_path=find_chromium(), args=list(FLAGS))
        try:
            yield browser
        finally:
            browser.close()


def show(
    browser: "Browser",
    url: str,
    width: int,
    height: int,
    on_error: Callable[[str], None] = lambda text: None,
) -> "Page":
    """Open the page at a size in px and return it when its widgets are there.

    ``on_error`` is told of exceptions in the page and of errors on its console.
    """
    page = browser.new_page(viewport={"width": width, "height": height})
    page.set_default_timeout(PATIENCE)
    page.on("pageerror", lambda error: on_error(str(error)))
    page.on("console", lambda said: on_error(said.text) if said.type == "error" else None)
    page.goto(url)
    page.wait_for_selector("#status")
    return page


def choose(page: "Page", label: str, option: str) -> None:
    """Choose an option of one of the page's dropdowns."""
    page.get_by_label(label, exact=True).first.click()
    page.get_by_role("option", name=option, exact=True).click()
