"""Names for the entries of a message's arrays: joints, sensors, axes."""

from collections.abc import Mapping, Sequence
from typing import Any

from robot_model import Robot

XYZ = ("x", "y", "z")
WXYZ = ("w", "x", "y", "z")
WRENCH = ("fx", "fy", "fz", "mx", "my", "mz")
TWIST = ("vx", "vy", "vz", "wx", "wy", "wz")
OWN = ("joints", "sensors", "frame", "link", "support_frames")  # lists of names in messages


class Labels:
    """Names entries of arrays by what the robot's description and the message itself say.

    Args:
        robots: Robots by model hash, from `robots_of`.
    """

    def __init__(self, robots: Mapping[str, Robot]):
        self._robots = robots
        self._known: dict[tuple, list[tuple[str, ...]]] = {}

    def of(
        self, field: dict[str, Any], shape: tuple[int, ...], message: Any, model: str
    ) -> list[tuple[str, ...]]:
        """Return the names along each axis of a field's value.

        Args:
            field: The field as the port describes it.
            shape: The value's shape.
            message: The message that holds it.
            model: Model hash of its envelope.
        """
        own = tuple([tuple(getattr(message, name, ())) for name in OWN])
        key = (field["name"], shape, own, model, type(message))
        if key not in self._known:
            dims = zip(field["shape"], shape, strict=True)
            robot = self._robots.get(model)
            self._known[key] = [_axis(field, *dim, robot, own) for dim in dims]
        return self._known[key]


def _axis(
    field: dict[str, Any],
    symbol: str | int,
    length: int,
    robot: Robot | None,
    own: Sequence[tuple[str, ...]],
) -> tuple[str, ...]:
    if isinstance(symbol, int):
        return _components(field, length)
    for names in (*_of_robot(robot, symbol), *own):
        if names and len(names) == length:
            return unique(names)
    return numbers(length)


def _of_robot(robot: Robot | None, symbol: str) -> list[tuple[str, ...]]:
    if robot is None:
        return []
    subtrees = tuple(subtree.name for subtree in robot.subtrees)
    known = {"n": robot.joints, "k": robot.ft_sensors, "m": robot.imus, "s": subtrees}
    return [known[symbol]] if symbol in known else []


def _components(field: dict[str, Any], length: int) -> tuple[str, ...]:
    unit = field["unit"]
    if length == 3:
        return XYZ
    if length == 4 and "wxyz" in field["name"]:
        return WXYZ
    if length == 6 and unit.startswith("N, N m"):
        return WRENCH
    if length == 6 and unit.startswith("m/s, rad/s"):
        return TWIST
    return numbers(length)


def numbers(length: int) -> tuple[str, ...]:
    """Return the names 0, 1, 2, …"""
    return tuple(map(str, range(length)))


def unique(names: Sequence[str]) -> tuple[str, ...]:
    """Return the names; a second one of the same name gets ``_2``."""
    seen: dict[str, int] = {}
    result = []
    for name in names:
        seen[name] = seen.get(name, 0) + 1
        result.append(name if seen[name] == 1 else f"{name}_{seen[name]}")
    return tuple(result)


def unit_at(field: dict[str, Any], index: tuple[int, ...]) -> str:
    """Return the unit of one entry; of a wrench or twist, that of its half."""
    parts = field["unit"].split(", ")
    if len(parts) == 2 and "(" not in field["unit"] and field["shape"][-1:] == [6]:
        return parts[index[-1] // 3]
    return field["unit"]
