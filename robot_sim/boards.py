"""Motor boards: what the electronics in the robot do with a command, tick by tick."""

from typing import Literal

import numpy as np

from robot_model import Robot

Array = np.ndarray
Mode = Literal["position", "velocity", "torque"]
MODES: tuple[Mode, ...] = ("position", "velocity", "torque")

FADE_AFTER = 0.05  # s without a command until the feed-forward begins to fade
FADE_TIME = 0.5  # s until it is gone


class Boards:
    """Position mode is PD with the description's gains plus a feed-forward torque.

    Velocity mode moves the reference of the position loop; torque mode applies the
    torque. Without a command for 50 ms, velocity and torque mode become position mode
    at the present posture, and the feed-forward fades to zero over 0.5 s. A plant
    driven by hand, in process, may switch this watchdog off.

    Args:
        robot: Gives gains, limits and the home posture, which is held before any command.
        tick: Control period [s].
        watchdog: Whether silence fades the feed-forward.
    """

    def __init__(self, robot: Robot, tick: float, watchdog: bool = True):
        self._robot = robot
        self._tick = tick
        self.watchdog = watchdog
        self._kp = np.array(robot.board_kp)
        self._kd = np.array(robot.board_kd)
        self._most = np.array(robot.torque_limit)
        self._least = -self._most
        self._lower = np.array(robot.position_lower)
        self._upper = np.array(robot.position_upper)
        self._zero = np.zeros(robot.n)
        self.restart()

    def restart(self) -> None:
        """Hold the home posture without feed-forward, as before the first command."""
        self.mode: Mode = "position"
        self.reference = np.array(self._robot.home)
        self.feedforward = self._zero
        self._value = self._zero
        self._silence = 0.0

    def command(self, mode: Mode, value: Array, feedforward: Array | None = None) -> None:
        """Take a command: rad, rad/s or N m by mode, and a feed-forward torque [N m].

        Raises:
            ValueError: unknown mode, wrong shape or a value that is not finite.
        """
        if mode not in MODES:
            raise ValueError(f"mode must be one of {', '.join(MODES)}, got {mode!r}")
        self._value = self._vector(value, mode)
        if feedforward is not None:
            self.feedforward = self._vector(feedforward, "feed-forward")
        if mode == "position":
            self.reference = _within(self._value, self._lower, self._upper)
        self.mode = mode
        self._silence = 0.0

    def _vector(self, value: Array, what: str) -> Array:
        array = np.array(value, dtype=float)
        if array.shape != self._zero.shape or not all(np.isfinite(array).tolist()):
            raise ValueError(
                f"{what} command must be {self._zero.size} finite numbers, "
                f"got shape {array.shape}: {array}"
            )
        return array

    def torque(self, q: Array, dq: Array, offset: Array | None = None) -> Array:
        """Return the motor torque (n,) [N m] of this tick; ``offset`` moves the reference."""
        fade = self._watch(q) if self.watchdog else 1.0
        if self.mode == "torque":
            torque = self._value + fade * self.feedforward
            self.reference = q  # where the other modes would begin
        else:
            torque = self._kp * (self._target(q, offset) - q) - self._kd * dq
            if self.mode == "velocity":
                torque += self._kd * self._value
            torque += fade * self.feedforward
        return _within(torque, self._least, self._most)

    def _target(self, q: Array, offset: Array | None) -> Array:
        if self.mode == "velocity":
            moved = self.reference + self._tick * self._value
            self.reference = _within(moved, self._lower, self._upper)
        if offset is None:
            return self.reference
        return _within(self.reference + offset, self._lower, self._upper)

    def _watch(self, q: Array) -> float:
        self._silence += self._tick
        late = self._silence - FADE_AFTER
        if late <= 0.0:
            return 1.0
        if self.mode != "position":
            self.mode = "position"
            self.reference = _within(q, self._lower, self._upper)
        return max(0.0, 1.0 - late / FADE_TIME)


def _within(value: Array, lower: Array, upper: Array) -> Array:
    """What np.clip does, at a third of its cost on a short vector."""
    return np.minimum(np.maximum(value, lower), upper)
