"""What a run was made on."""

import os
import platform
import sys
from importlib.metadata import version
from pathlib import Path

PACKAGES = ("eclipse-zenoh", "pyzmq", "msgpack", "numpy", "pin", "idyntree")


def describe() -> str:
    """Return processor, cores, system and versions in one sentence."""
    packages = ", ".join(f"{name} {version(name)}" for name in PACKAGES)
    python = ".".join(map(str, sys.version_info[:3]))
    return (
        f"{_processor()}, {os.cpu_count()} cores, {platform.system()} {platform.release()},"
        f" Python {python}, {packages}"
    )


def _processor() -> str:
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.machine()
