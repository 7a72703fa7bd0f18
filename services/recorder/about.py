"""What a recording was made with."""

import os
import platform
import sys
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path


def about() -> dict[str, str]:
    """Return version, machine and command, for the metadata of a recording."""
    return {
        "version": _version(),
        "python": platform.python_version(),
        "host": platform.node(),
        "kernel": f"{platform.system()} {platform.release()}",
        "cpu": f"{processor()}, {os.cpu_count()} cores",
        "command": " ".join([Path(sys.argv[0]).name, *sys.argv[1:]]),
    }


def _version() -> str:
    try:
        return version("wrenchbus")
    except PackageNotFoundError:
        return "not installed"


def processor() -> str:
    """Return the model of this machine's processor, as far as it is known."""
    try:
        lines = Path("/proc/cpuinfo").read_text().splitlines()
    except OSError:
        return platform.processor() or platform.machine()
    models = [line.partition(":")[2].strip() for line in lines if line.startswith("model name")]
    return models[0] if models else platform.machine()
