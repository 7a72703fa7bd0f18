"""Which picture is wanted; imports nothing, because the command's start pays for it."""

from enum import StrEnum


class View(StrEnum):
    """Which symbols a picture shows."""

    all = "all"
    kinematic = "kinematic"  # triangles (Figures 4.1 and 4.4 of the thesis)
    dynamic = "dynamic"  # rhombi (Figures 4.2 and 4.9)
