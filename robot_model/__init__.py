"""What a robot is: description files, models, surface, messages and ports.

The names below are imported at first use, so that a tool which only wants messages or
port names does not pay for Pinocchio.
"""

from importlib import import_module
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from robot_model.errors import DescriptionError
    from robot_model.load import load_robot, robot_name
    from robot_model.robot import Robot
    from robot_model.surface import Surface
    from robot_model.tree import TreeModel, build_tree

__all__ = [
    "DescriptionError",
    "Robot",
    "Surface",
    "TreeModel",
    "build_tree",
    "load_robot",
    "robot_name",
]

_HOMES = {
    "DescriptionError": "errors",
    "Robot": "robot",
    "Surface": "surface",
    "TreeModel": "tree",
    "build_tree": "tree",
    "load_robot": "load",
    "robot_name": "load",
}


def __getattr__(name: str) -> Any:
    if name not in _HOMES:
        raise AttributeError(f"module 'robot_model' has no attribute '{name}'")
    return getattr(import_module(f"robot_model.{_HOMES[name]}"), name)
