"""What this machine needs before anything runs."""

import sys
from collections.abc import Iterator
from importlib.metadata import PackageNotFoundError, requires, version

from deploy.doctor.result import Result, fail, ok, warn

PYTHON = (3, 11)


def machine_checks() -> Iterator[Result]:
    """Yield one result per thing that must be installed."""
    yield _python()
    yield _packages()
    yield _description()
    yield _browser()


def _python() -> Result:
    found = sys.version.split()[0]
    if sys.version_info < PYTHON:
        return fail("python", f"{found}; 3.11 or newer is needed")
    return ok("python", found)


def _packages() -> Result:
    missing, found = [], []
    for requirement in requires("wrenchbus") or []:
        if "extra ==" in requirement:
            continue
        try:
            found.append(f"{requirement} {version(requirement)}")
        except PackageNotFoundError:
            missing.append(requirement)
    if missing:
        return fail("packages", f"missing: {', '.join(missing)}; pip install them")
    return ok("packages", ", ".join(found))


def _description() -> Result:
    from robot_model import DescriptionError, load_robot

    try:
        robot = load_robot()
    except DescriptionError as error:
        return fail("robot", " ".join(str(error).split()))
    sensors = len(robot.ft_sensors)
    return ok("robot", f"{robot.name}: {robot.n} joints, {sensors} F/T sensors, fits its URDF")


def _browser() -> Result:
    from dashboard.chromium import find_chromium

    try:
        return ok("browser", find_chromium())
    except FileNotFoundError as error:
        return warn("browser", f"{error}; the browser test cannot run")
