"""Settings that every service of a robot has."""

from typing import ClassVar, Literal, Self

from pydantic import BaseModel, ConfigDict

Support = Literal["floor", "pole", "none"]


class RobotServiceConfig(BaseModel):
    """Unknown keys are refused; values are replaced as a whole, never changed in place."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    robot: str = "icub"  # name of a packaged description, or a path to a file
    support: Support = "floor"  # known contacts, which are never touches
    lockstep: bool = False  # acknowledge every stamp to the plant

    FIXED: ClassVar[tuple[str, ...]] = ("robot", "lockstep")  # while the service runs

    def check_change(self, new: Self) -> None:
        """Raise ValueError when something changes that cannot while the service runs."""
        for name in self.FIXED:
            if getattr(self, name) != getattr(new, name):
                raise ValueError(f"{name} cannot be changed while the service runs")
