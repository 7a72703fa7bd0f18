"""From ``wrenchbus demo`` to the first frame of the robot in a headless Chromium without a GPU."""

import time
from statistics import median
from typing import Any

from benchmarks.load import processor_seconds
from benchmarks.running_demo import running_demo
from dashboard.chromium import open_browser

SIZE = {"width": 1440, "height": 900}  # px
PATIENCE = 180_000  # ms
ROBOT = 30_000  # corners of triangles in a frame: the robot is among them
TARGET = 10.0  # s
STARTS = 5

# viser draws all the time; what a frame holds is known when the next one begins
COUNT_FRAMES = f"""
window.framesOfRobot = 0;
let corners = 0;
for (const name of ["drawElements", "drawArrays"]) {{
  const draw = WebGL2RenderingContext.prototype[name];
  WebGL2RenderingContext.prototype[name] = function (mode, first, second, ...rest) {{
    if (mode === this.TRIANGLES) corners += name === "drawElements" ? first : second;
    return draw.call(this, mode, first, second, ...rest);
  }};
}}
const count = () => {{
  if (corners > {ROBOT}) window.framesOfRobot += 1;
  corners = 0;
  requestAnimationFrame(count);
}};
requestAnimationFrame(count);
"""
LIVE = "document.getElementById('status')?.innerText.startsWith('live')"


def run(quick: bool = False) -> list[dict[str, Any]]:
    """Return the times, medians of some starts."""
    starts = [_start() for _ in range(1 if quick else STARTS)]
    ready, used, shown, moving = (median(times) for times in zip(*starts, strict=True))
    return [
        _row("demo: start to the page's address", ready),
        _row("demo: processor time of all its processes until then", used),
        _row("page: opened to the second frame with the robot, live", shown),
        _row("demo: start to the robot moving in the browser", moving, TARGET),
        _row("the same, slowest start", max(start[-1] for start in starts)),
    ]


def _start() -> tuple[float, float, float, float]:
    """Start a demo; the browser is open before, as a user's is."""
    with open_browser() as browser:
        page = browser.new_page(viewport=SIZE)  # type: ignore[arg-type]
        page.set_default_timeout(PATIENCE)
        page.add_init_script(COUNT_FRAMES)
        with running_demo() as demo:
            used = sum(map(processor_seconds, demo.pids.values()))
            url = demo.node.call("/dashboard/rpc:i", "status")["url"]
            opened = time.monotonic()
            page.goto(url)
            page.wait_for_function(f"{LIVE} && window.framesOfRobot > 1", polling=50)
            shown = time.monotonic() - opened
    return demo.ready_after, used, shown, demo.ready_after + shown


def _row(name: str, seconds: float, limit: float | None = None) -> dict[str, Any]:
    row: dict[str, Any] = {"name": name, "value": seconds, "unit": "s"}
    if limit is not None:
        row |= {"target": f"<= {limit:g} s", "met": seconds <= limit}
    return row
