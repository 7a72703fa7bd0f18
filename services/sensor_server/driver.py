"""What the sensor server needs of hardware, real or simulated."""

from importlib import import_module
from typing import Any, Literal, NamedTuple, Protocol

from bus import Node
from robot_model import Robot
from robot_model.messages import MotorCommand, RawFrame

FtConvention = Literal["wrenchbus", "urdf"]
OURS = {
    "plant": "services.sensor_server.plant_driver:PlantDriver",
    "replay": "services.sensor_server.replay_driver:ReplayDriver",
}


class Reading(NamedTuple):
    """One raw frame and when it was measured."""

    frame: RawFrame
    stamp: int  # ns of the session's clock
    clock: int  # 0 wall, 1 simulated
    acquired: int  # wall ns
    valid: bool = True
    reason: str = ""


class Driver(Protocol):
    """Reads the sensors of a robot and writes to its motor boards.

    Made as ``Driver(node, robot, config)``; nothing happens before ``open``. All
    calls come from one thread. ``tests/services/sensor_server/test_driver_contract.py`` says in
    tests what a driver must do.

    Attributes:
        ft_convention: ``wrenchbus`` (parent on child, in the frame that bears the
            sensor's name) or ``urdf`` (as the URDF's sensor element says).
        checked: Whether all values are known to be finite, and 0.0 where they are
            invalid; the server looks at every frame of other drivers.
    """

    ft_convention: FtConvention
    checked: bool

    def open(self) -> None:
        """Connect. Raises OSError or ValueError with what is missing."""

    def read(self, timeout: float) -> Reading | None:
        """Return the next frame, none skipped; None when none came in ``timeout`` [s]."""

    @property
    def silence(self) -> str:
        """Why there is no fresh frame, empty while there is; a paused clock is no reason."""
        ...

    @property
    def paused(self) -> bool:
        """Whether the robot's clock is paused."""
        ...

    def write(self, command: MotorCommand, reading: Reading) -> None:
        """Send a command, decided on ``reading``, to the boards; never blocks."""

    def close(self) -> None:
        """Disconnect; a second call does nothing."""


def make_driver(name: str, node: Node, robot: Robot, config: Any) -> Driver:
    """Make the driver ``plant`` or ``replay``, or the class named as ``package.module:Class``.

    Raises:
        ValueError: there is no such driver.
    """
    module, _, class_name = OURS.get(name, name).partition(":")
    try:
        return getattr(import_module(module), class_name)(node, robot, config)
    except (ImportError, AttributeError, ValueError) as error:
        raise ValueError(
            f"driver: expected 'plant', 'replay' or 'package.module:Class', got {name!r} ({error})"
        ) from None
