"""What the boards are told: the accepted command or a safe hold, and the feed-forward."""

from dataclasses import dataclass

import numpy as np

from robot_model import Robot
from robot_model.messages import MotorCommand
from services.sensor_server.config import CommandConfig
from services.sensor_server.lease import Lease

Array = np.ndarray
MODES = ("position", "velocity", "torque")
START_TOLERANCE = 0.3  # rad; nearer to home than this, the robot holds the home posture


class CommandRefused(ValueError):
    """A command that changes nothing; the text says why."""


@dataclass
class _FeedForward:
    """A torque whose factor moves between 0 and 1 within the fading time."""

    torque: Array
    received: float = -np.inf  # s
    factor: float = 0.0

    def advance(self, now: float, elapsed: float, wanted: bool, config: CommandConfig) -> None:
        alive = wanted and now - self.received <= config.feedforward_timeout
        change = elapsed / config.feedforward_fade
        self.factor = min(1.0, self.factor + change) if alive else max(0.0, self.factor - change)


class Commander:
    """Everything that moves the robot goes through here. Pure: the time is an argument.

    Position commands stand until the next one. Velocity and torque commands that
    are not renewed end in a safe hold: the present posture with the boards' gains,
    the feed-forward faded, until the next command. ``stop`` is a safe hold that
    refuses commands until ``release``. The feed-forward fades in and out, so that
    a compensator that starts or dies does not jerk the robot.

    Args:
        robot: Limits and home posture.
        config: Time limits.
    """

    def __init__(self, robot: Robot, config: CommandConfig):
        self._robot = robot
        self._config = config
        self._lease = Lease(config.lease)
        self._feedforward = _FeedForward(np.zeros(robot.n))
        self._posture: Array | None = None
        self._value = np.array(robot.home)
        self._commanded = 0.0  # s
        self._now = 0.0
        self.mode = "position"
        self.stopped = False
        self.reason = ""  # why the robot is in a safe hold; empty when it is not
        self.changed = False  # since the last ``motor_command``

    def configure(self, config: CommandConfig) -> None:
        """Take new time limits."""
        self._config = config
        self._lease.duration = config.lease

    def restart(self) -> None:
        """Forget posture and command; a stop stays in force."""
        self._posture = None
        self._lease.end()
        self._set("position", self._value)

    @property
    def ready(self) -> bool:
        """Whether every joint has been measured, so that there is a posture to hold."""
        return self._posture is not None

    def measured(self, q: Array, valid: Array) -> None:
        """Take the present posture (n,) [rad]; joints that are not valid keep their last one."""
        if self._posture is not None:
            self._posture = np.where(valid, q, self._posture)
        elif valid.all():
            self._posture = np.array(q)
            near_home = np.abs(q - self._robot.home).max() < START_TOLERANCE
            self._value = self._clip("position", self._robot.home if near_home else q)

    def command(self, mode: str, value: Array, source: bytes, now: float) -> None:
        """Take a joint command (n,) [rad, rad/s or N m], clipped to the robot's limits.

        Raises:
            CommandRefused: the robot is stopped, somebody else holds the lease, or the
                command is not one.
        """
        if self.stopped:
            raise CommandRefused(f"stopped ({self.reason}); release first")
        if not self.ready:
            raise CommandRefused("no joint positions yet")
        if mode not in MODES:
            raise CommandRefused(f"mode must be one of {', '.join(MODES)}, got {mode!r}")
        if value.shape != self._value.shape or not np.isfinite(value).all():
            raise CommandRefused(f"expected {self._robot.n} finite numbers, got {value}")
        if not self._lease.take(source, now):
            raise CommandRefused("another writer holds the lease of the command port")
        self._set(mode, self._clip(mode, value))
        self._commanded = now
        self.reason = ""

    def feedforward(self, torque: Array, now: float) -> None:
        """Take a valid feed-forward (n,) [N m]."""
        limit = self._robot.torque_limit
        self._feedforward.torque = np.clip(torque, -limit, limit)
        self._feedforward.received = now

    def stop(self, reason: str) -> None:
        """Hold the present posture and refuse commands until ``release``."""
        self.stopped = True
        self._hold(reason)

    def release(self) -> None:
        """Accept commands and feed-forward again; the posture stays until the first command."""
        self.stopped = False
        self.reason = ""
        self.changed = True

    def advance(self, now: float) -> None:
        """Let the watchdogs see the time [s]."""
        elapsed, self._now = max(0.0, now - self._now), now
        age = now - self._commanded
        if self.mode != "position" and age > self._config.command_timeout:
            self._hold(f"no {self.mode} command for {age * 1e3:.0f} ms")
        self._feedforward.advance(now, elapsed, not self.reason, self._config)

    def motor_command(self) -> MotorCommand:
        """Return what the boards shall do now."""
        self.changed = False
        torque = self._feedforward.factor * self._feedforward.torque
        return MotorCommand(mode=self.mode, value=self._value, feedforward=torque)

    def status(self) -> dict[str, object]:
        """Return the state for people."""
        owner = self._lease.owner(self._now)
        return {
            "mode": self.mode,
            "holding": bool(self.reason),
            "stopped": self.stopped,
            "reason": self.reason,
            "feedforward": self._feedforward.factor,
            "writer": owner.hex() if owner else "",
        }

    def _hold(self, reason: str) -> None:
        posture = self._value if self._posture is None else self._posture
        self._lease.end()
        self._set("position", self._clip("position", posture))
        self.reason = reason

    def _set(self, mode: str, value: Array) -> None:
        self.mode, self._value = mode, value
        self.changed = True

    def _clip(self, mode: str, value: Array) -> Array:
        robot = self._robot
        if mode == "position":
            return np.clip(value, robot.position_lower, robot.position_upper)
        limit = robot.velocity_limit if mode == "velocity" else robot.torque_limit
        return np.clip(value, -limit, limit)
