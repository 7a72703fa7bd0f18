"""What a run was made on."""

import os
import platform
import sys
from importlib.metadata import version

from services.recorder.about import processor

PACKAGES = ("eclipse-zenoh", "pyzmq", "msgpack", "numpy", "pin", "idyntree")


def describe() -> str:
    """Return processor, cores, system and versions in one sentence."""
    packages = ", ".join(f"{name} {version(name)}" for name in PACKAGES)
    python = ".".join(map(str, sys.version_info[:3]))
    return (
        f"{processor()}, {os.cpu_count()} cores, {platform.system()} {platform.release()},"
        f" Python {python}, {packages}"
    )
