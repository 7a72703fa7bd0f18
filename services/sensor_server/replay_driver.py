"""A recording as a driver: its raw frames in real time, at a rate, or in lockstep."""

import logging
import time

from bus import BusError, LockstepTimeout, Node
from bus.clock import ClockServer, State
from bus.decoder import Decoder
from bus.envelope import SIMULATED
from bus.errors import WireError
from bus.lockstep import Lockstep
from bus.names import did_you_mean
from bus.recording.player import Player
from bus.recording.reader import Recording, RecordingError
from bus.schema import type_name
from robot_model import Robot, ports
from robot_model.messages import MotorCommand, RawFrame
from services.sensor_server.config import SensorServerConfig
from services.sensor_server.driver import FtConvention, Reading

logger = logging.getLogger(__name__)

IDLE = 0.05  # s
PATIENCE = 5_000_000_000  # ns of wall time until a missing lockstep participant is an error
PERIODS = 10  # without a frame are a silence ...
LEAST = 0.02  # ... but not less than this many seconds


class ReplayDriver:
    """Reads the raw frames of a recording; ``/player/rpc:i`` moves in it.

    The clock is the recording's: simulated, paused with the player and at the end, set back
    by a seek. Frames are acquired when they are handed out. In lockstep the next one waits
    for all participants. There are no boards: commands are counted, and said once.

    Attributes:
        ignored: Motor commands that went nowhere.
    """

    ft_convention: FtConvention = "wrenchbus"
    checked = True  # by the decoder, which refuses other messages

    def __init__(self, node: Node, robot: Robot, config: SensorServerConfig):
        self._node, self._robot, self._config = node, robot, config
        self._settings = config.replay
        self._decoder = Decoder(RawFrame, robot.model_hash, robot.dimensions)
        self._player: Player | None = None
        self._lockstep: Lockstep | None = None
        self._stamp = -1  # of the last frame, ns
        self._waited = 0  # monotonic [ns] since when participants are waited for
        self._arrival = time.monotonic()
        self.ignored = self.refused = 0

    def open(self) -> None:
        """Open the recording. Raises ValueError or BusError with what is wrong with it."""
        if not self._settings.file:
            raise ValueError("replay.file: expected a recording, as in --set replay.file=log.mcap")
        self.load(Recording(self._settings.file))

    def load(self, tape: Recording) -> None:
        """Read frames from an open recording."""
        settings, robot = self._settings, self._robot
        port = settings.port or ports.name("raw", robot)
        _check(tape, port)
        if self._config.lockstep:
            self._lockstep = Lockstep(self._node, self._participants())
        self._clock = ClockServer(self._node, ports.name("clock", robot))
        rate = None if self._config.lockstep else settings.rate
        part = {"begin": settings.begin, "end": settings.end}
        self._player = Player(tape, [port], rate, settings.loop, **part, paused=settings.paused)
        self._player.serve(self._node, self._counters)
        period = 1.0 / (tape.ports[port].nominal_hz or self._config.rate)
        self._longest = max(PERIODS * period, LEAST)  # s

    def read(self, timeout: float) -> Reading | None:
        """Return the next frame when it is due, waiting on the bus for at most ``timeout`` [s]."""
        player = self._opened
        deadline = time.monotonic() + timeout
        while not self._is_awaited(deadline):
            if (reading := self._next(player)) is not None:
                return reading
            self._tell_time()
            remaining = deadline - time.monotonic()
            if remaining <= 0.0 or not self._node.running:
                return None
            due = player.remaining
            self._node.wait(min(remaining, IDLE if due is None else due))
        return None

    @property
    def silence(self) -> str:
        """Why there is no fresh frame; standing still, or in lockstep, is no reason."""
        if self.paused or self._config.lockstep:
            return ""
        silent = time.monotonic() - self._arrival
        if silent <= self._longest / self._opened.status()["rate"]:
            return ""
        return f"the recording has no frame for {silent * 1e3:.0f} ms"

    @property
    def paused(self) -> bool:
        return self._opened.paused

    def write(self, command: MotorCommand, reading: Reading) -> None:
        """Count a command; a recording has no boards that could follow it."""
        self.ignored += 1
        if self.ignored == 1:
            logger.warning("a recording has no motor boards: commands are ignored")

    def close(self) -> None:
        """Close the recording."""
        if self._player is not None:
            self._player.close()

    def _participants(self) -> list[str]:
        others = [name for name in self._settings.participants if name != self._node.name]
        if not others:
            raise ValueError("lockstep: replay.participants: expected at least one, got none")
        return others

    def _counters(self) -> dict[str, int]:
        return {"commands_ignored": self.ignored, "frames_refused": self.refused}

    @property
    def _opened(self) -> Player:
        assert self._player is not None, "open() comes first"
        return self._player

    def _next(self, player: Player) -> Reading | None:
        while (item := player.next()) is not None:
            try:
                frame, envelope = self._decoder.decode(item.data)
            except WireError as error:
                self._refuse(str(error))
                continue
            self._stamp, self._arrival = envelope.stamp, time.monotonic()
            self._tell_time()
            acquired = time.time_ns()
            return Reading(
                frame, envelope.stamp, SIMULATED, acquired, envelope.valid, envelope.reason
            )
        return None

    def _refuse(self, why: str) -> None:
        self.refused += 1
        if self.refused == 1:
            logger.error("a recorded frame is refused: %s", why)

    def _tell_time(self) -> None:
        if self._stamp >= 0:
            state: State = "paused" if self.paused else "running"
            self._clock.update(self._stamp, state)

    def _is_awaited(self, deadline: float) -> bool:
        """Whether a participant still has the last frame, after waiting for it until a deadline."""
        if self._lockstep is None or self._stamp < 0:
            return False
        try:
            self._lockstep.wait(self._stamp, max(0.0, deadline - time.monotonic()))
        except LockstepTimeout as error:
            self._complain(str(error).partition(" within ")[0])
            return True
        except BusError:  # asked to end meanwhile
            return True
        self._waited = 0
        return False

    def _complain(self, why: str) -> None:
        """Name who is missing, every five seconds."""
        self._tell_time()
        now = time.monotonic_ns()
        self._waited = self._waited or now
        if now - self._waited > PATIENCE:
            self._waited = now
            logger.error("lockstep: %s; still waiting", why)


def _check(tape: Recording, port: str) -> None:
    """Refuse a recording without raw frames; say what it has."""
    if port not in tape.ports:
        hint = did_you_mean(port, tape.ports)
        raise RecordingError(f"{tape.path}: no port {port}{hint}; the driver replays raw frames")
    recorded = tape.ports[port].type
    if recorded != type_name(RawFrame):
        raise RecordingError(f"{tape.path}: {port}: expected {type_name(RawFrame)}, got {recorded}")
