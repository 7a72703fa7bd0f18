"""What a robot is: description files, models, surface, messages and ports."""

from robot_model.errors import DescriptionError
from robot_model.load import load_robot
from robot_model.robot import Robot
from robot_model.tree import TreeModel, build_tree

__all__ = ["DescriptionError", "Robot", "TreeModel", "build_tree", "load_robot"]
