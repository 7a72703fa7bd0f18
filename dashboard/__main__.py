"""``python -m dashboard``"""

import os
import sys

from bus.service import serve
from robot_model import ports, robot_name

from .config import DashboardConfig
from .service import main

NICE = 10  # drawing must not delay the control chain: its bursts set that chain's worst latency


def _clock(config: DashboardConfig) -> str:
    return ports.name("clock", robot_name(config.robot))


if __name__ == "__main__":
    # not before all is imported: among eight that start, a nice one is ready last by far;
    # and before any thread exists: on Linux niceness belongs to the thread
    os.setpriority(os.PRIO_PROCESS, 0, max(NICE, os.getpriority(os.PRIO_PROCESS, 0)))
    sys.exit(serve(main, DashboardConfig, "dashboard", __package__, clock_port=_clock))
