"""Take the picture of the running page: ``python -m dashboard.picture -o page.png``.

It asks the dashboard on the bus for its address, opens it in a headless Chromium,
presses Push, and takes the picture when the alarm line shows the contact. Needs
playwright and a Chromium on the path.
"""

import argparse
import sys
from pathlib import Path
from typing import TYPE_CHECKING

from bus import BusError, Node
from bus.introspection import wait_for_service
from robot_model import ports

from .chromium import choose, open_browser, show

if TYPE_CHECKING:
    from playwright.sync_api import Page

SEEN = 2500  # [ms] for the places of the touch to be drawn likewise
SETTLE = 3000  # [ms] for the meshes to be drawn in software
TOUCHED = "document.getElementById('alarm')?.innerText.startsWith('contact: ')"
STATUS_ABOVE = "document.getElementById('status').scrollIntoView({inline: 'nearest'})"
LIVE = "document.getElementById('status')?.innerText.startsWith('live')"


def main(argv: list[str] | None = None) -> int:
    """Take one picture; return the exit status."""
    options = parser().parse_args(argv)
    try:
        url = options.url or find_page(options.connect, options.namespace)
        take(url, options.output, options.size, options.link, options.direction)
    except (BusError, OSError, ImportError) as error:
        print(f"picture: {error}", file=sys.stderr)
        return 1
    print(options.output)
    return 0


def parser() -> argparse.ArgumentParser:
    """Return the parser of the command line."""
    result = argparse.ArgumentParser(
        prog="python -m dashboard.picture",
        description="Take a picture of the running page.",
        epilog="example: python -m dashboard.picture -o docs/images/page.png --link l_forearm",
    )
    add = result.add_argument
    add("-o", "--output", type=Path, required=True, metavar="FILE", help="PNG to write")
    add("-e", "--connect", metavar="ENDPOINT", help="the hub; default: the running one")
    add("--namespace", help="prefix of all keys")
    add("--url", help="address of the page; default: what the dashboard on the bus says")
    add("--link", help="link to push; default: the one that the page proposes")
    add("--direction", help="of the push, such as +x")
    add("--size", type=_size, default=(1440, 900), metavar="WIDTHxHEIGHT", help="[px]")
    return result


def _size(text: str) -> tuple[int, int]:
    width, _, height = text.partition("x")
    return int(width), int(height)


def find_page(connect: str | None, namespace: str | None) -> str:
    """Return the address of the page that a dashboard on the bus serves."""
    with Node("picture", connect=connect, namespace=namespace) as node:
        wait_for_service(node, "dashboard")
        return str(node.call(ports.rpc("dashboard"), "status")["url"])


def take(
    url: str, file: Path, size: tuple[int, int], link: str | None, direction: str | None
) -> None:
    """Open the page, push the robot, and take the picture while it is touched."""
    with open_browser() as browser:
        page = show(browser, url, *size)
        page.wait_for_function(LIVE)
        page.wait_for_timeout(SETTLE)
        _dismiss_notifications(page)
        for label, option in (("Link", link), ("Direction", direction)):
            if option:
                choose(page, label, option)
        page.get_by_role("button", name="Push", exact=True).click()
        page.wait_for_function(TOUCHED, polling=100)
        page.evaluate(STATUS_ABOVE)
        page.wait_for_timeout(SEEN)
        file.parent.mkdir(parents=True, exist_ok=True)
        page.screenshot(path=file)


def _dismiss_notifications(page: "Page") -> None:
    """A browser without a GPU warns of it in the picture's corner."""
    for close in page.locator(".mantine-Notification-closeButton").all():
        close.click()


if __name__ == "__main__":
    sys.exit(main())
