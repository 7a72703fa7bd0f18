"""The page as a process."""

import logging
import time
from contextlib import ExitStack
from typing import Any

from bus import Node
from robot_model import load_robot

from .config import DashboardConfig
from .page import Browsers, Page
from .server import open_server

log = logging.getLogger(__name__)

STEP = 0.05  # [s] at most between looks at the bus's requests


def main(node: Node, config: DashboardConfig) -> None:
    """Serve the page until the process is asked to end."""
    robot = load_robot(config.robot)
    with ExitStack() as stack:
        server = open_server(config)
        stack.callback(server.stop)
        page = Page(node, robot, robot.load_surface(), server, config)
        stack.callback(page.close)
        node.parameters.on_change(_refuse)
        node.verb("status", lambda: _status(node, server.url), "state, and the page's address")
        node.ready()
        print(f"dashboard: {server.url}", flush=True)
        _loop(node, page, config)


def _status(node: Node, url: str) -> dict[str, Any]:
    return {**node.status(), "url": url}


def _refuse(old: DashboardConfig, new: DashboardConfig) -> None:
    """Refuse what would have no effect; the support is of no concern to the page."""
    changed = [key for key in type(new).model_fields if getattr(old, key) != getattr(new, key)]
    if late := [key for key in changed if key != "support"]:
        raise ValueError(
            f"{', '.join(late)}: cannot change while the page is served; restart the dashboard"
        )


def _loop(node: Node, page: Page, config: DashboardConfig) -> None:
    """Sleep through arriving messages: only the newest at the time of a frame is drawn."""
    due, browsers = time.monotonic(), Browsers(watch=False, load=False)
    page.rest(True)
    while node.running:
        page.update()
        moves = browsers.watch and not browsers.load
        period = 1.0 / (config.scene_rate if moves else config.idle_rate)
        due = max(due + period, time.monotonic())
        while node.running and (remaining := due - time.monotonic()) > 0.0:
            time.sleep(min(remaining, STEP))
            node.wait(0.0)
            before, browsers = browsers, page.look()
            if before != browsers:
                page.rest(not browsers.watch)
                break
