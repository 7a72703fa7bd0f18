"""Motions: slow sinusoids on the joints' position references."""

from dataclasses import dataclass, replace

import numpy as np
from pydantic import BaseModel, ConfigDict, Field

from robot_model import Robot
from robot_model.names import did_you_mean

Array = np.ndarray
FADE = 2.0  # s from standing still to full amplitude, and back


class Sinusoid(BaseModel):
    """Motion of one joint about its reference."""

    model_config = ConfigDict(extra="forbid", frozen=True)

    amplitude: float = Field(ge=0, le=3.2)  # rad
    frequency: float = Field(gt=0, le=5)  # Hz
    phase: float = 0.0  # rad


@dataclass(frozen=True, eq=False)
class Motion:
    """A named set of sinusoids; fades in when started and out when stopped."""

    name: str
    joints: dict[str, Sinusoid]
    amplitude: Array | float = 0.0  # (n,) rad, once checked against a robot
    speed: Array | float = 0.0  # (n,) rad/s
    phase: Array | float = 0.0  # (n,) rad
    start: float = 0.0  # s
    stop: float = np.inf  # s

    def checked(self, robot: Robot) -> "Motion":
        """Return the motion with its numbers in the robot's joint order.

        Raises:
            LookupError: a joint that the robot has not.
        """
        amplitude, speed, phase = np.zeros((3, robot.n))
        for name, sinusoid in self.joints.items():
            if name not in robot.joints:
                hint = did_you_mean(name, robot.joints)
                raise LookupError(f"motion {self.name!r}: {robot.name} has no joint {name!r}{hint}")
            i = robot.joints.index(name)
            amplitude[i], phase[i] = sinusoid.amplitude, sinusoid.phase
            speed[i] = 2 * np.pi * sinusoid.frequency
        return replace(self, amplitude=amplitude, speed=speed, phase=phase)

    def started(self, time: float) -> "Motion":
        return replace(self, start=time, stop=np.inf)

    def stopped(self, time: float) -> "Motion":
        return replace(self, stop=min(time, self.stop))

    def ended(self, time: float) -> bool:
        """Whether it has faded out."""
        return time >= self.stop + FADE

    def offset(self, time: float) -> Array:
        """Return what to add to the position reference (n,) [rad] at a time [s]."""
        rising = (time - self.start) / FADE
        falling = 1.0 - (time - self.stop) / FADE
        scale = min(1.0, max(0.0, min(rising, falling)))
        # A quarter-wave start would jump; the smooth ramp keeps velocity continuous.
        scale = scale * scale * (3.0 - 2.0 * scale)
        return scale * self.amplitude * np.sin(self.speed * (time - self.start) + self.phase)


def followed(
    present: Motion | None, motion: Motion | None, robot: Robot, now: float
) -> Motion | None:
    """Return what moves from a time [s] on: another motion, or the present one fading out."""
    if motion is not None:
        return motion.checked(robot).started(now)
    return None if present is None else present.stopped(now)
