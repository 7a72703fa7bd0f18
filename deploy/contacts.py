"""Contacts as they are typed: ``FRAME[:X,Y,Z][:wrench|force|none|direction=X,Y,Z]``."""

import numpy as np

from deploy.errors import UsageError
from estimation.contact_set import Touch
from robot_model import Robot

UNKNOWNS = ("wrench", "force", "none")
DIRECTION = "direction="
FORM = "FRAME[:X,Y,Z][:wrench|force|none|direction=X,Y,Z]"


def read_touch(text: str) -> Touch:
    """Read one contact; UsageError when it has another form."""
    frame, *parts = text.split(":")
    point, unknown, vector = np.zeros(3), "wrench", None
    if parts and not _is_kind(parts[0]):
        point = _vector(parts.pop(0), text)
    if parts:
        unknown, vector = _kind(parts.pop(0), text)
    if not frame or parts:
        raise UsageError(f"contact: expected {FORM}, got {text!r}")
    return Touch(frame, point, unknown, vector)


def _is_kind(part: str) -> bool:
    return part.partition("=")[0].isalpha()


def _kind(part: str, text: str) -> tuple[str, np.ndarray | None]:
    if part in UNKNOWNS:
        return part, None
    if not part.startswith(DIRECTION):
        raise UsageError(f"contact: expected {FORM}, got {part!r} in {text!r}")
    direction = _vector(part.removeprefix(DIRECTION), text)
    if not direction.any():
        raise UsageError(f"contact: expected a direction of any length but zero, got {text!r}")
    return "direction", direction


def _vector(part: str, text: str) -> np.ndarray:
    try:
        x, y, z = (float(number) for number in part.split(","))
    except ValueError:
        raise UsageError(
            f"contact: expected X,Y,Z such as 0,0,0.1, got {part!r} in {text!r}"
        ) from None
    if not np.isfinite((x, y, z)).all():
        raise UsageError(f"contact: expected finite numbers, got {part!r} in {text!r}")
    return np.array([x, y, z])


def support_of(robot: Robot, wanted: str | None) -> str:
    """Return the kind of support: the floor where the robot can stand, unless told otherwise."""
    return wanted or ("floor" if "floor" in robot.supports else "none")
