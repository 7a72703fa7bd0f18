"""Plays a recording on the bus: its bytes, under the names of its ports, with its clock."""

from collections.abc import Iterable
from fnmatch import fnmatchcase

from bus.clock import Clock, ClockServer, State
from bus.decoder import Decoder
from bus.envelope import SIMULATED
from bus.errors import WireError
from bus.names import check_name, did_you_mean
from bus.node import Node
from bus.recording.player import Player
from bus.recording.raw_output import open_raw_output
from bus.recording.read_ahead import Item
from bus.recording.reader import Port, Recording, RecordingError

BURST = 500  # messages, after which requests and keys are looked at
IDLE = 0.05  # s
# unless named: of a lockstep's participants, and of services of which some run here too
NOT_PLAYED = ("/*/acknowledged:o", "/*/log:o")


def select_ports(tape: Recording, patterns: Iterable[str]) -> dict[str, Port]:
    """Return the ports to play: those that match a name or pattern, else all outputs.

    Raises:
        RecordingError: A pattern matches nothing; near names are suggested.
    """
    patterns = list(patterns)
    if not patterns:
        return {
            name: port
            for name, port in tape.ports.items()
            if port.direction == "output" and not any(fnmatchcase(name, p) for p in NOT_PLAYED)
        }
    chosen: set[str] = set()
    for pattern in patterns:
        found = {name for name in tape.ports if fnmatchcase(name, pattern)}
        if not found:
            hint = did_you_mean(pattern, tape.ports)
            raise RecordingError(f"{tape.path}: no port {pattern}{hint}")
        chosen |= found
    return {name: tape.ports[name] for name in sorted(chosen)}


class Playback:
    """Writes what a player hands out; serves the simulated clock.

    Args:
        node: Not ready yet; afterwards it owns the names of the ports.
        ports: As `select_ports` gives them; a recorded clock is served, not copied.
        prefix: Before every name, as in ``/log``.
    """

    def __init__(self, node: Node, player: Player, ports: dict[str, Port], prefix: str = ""):
        self._node, self._player = node, player
        self.refused = 0  # messages of another type than their port
        clocks = [name for name, port in ports.items() if port.type == Clock.TYPE]
        self._types = {name: port.type for name, port in ports.items()}
        self._outputs = {
            name: open_raw_output(node, check_name(prefix + name), port)
            for name, port in ports.items()
            if name not in clocks
        }
        self._recorded_clock = clocks[0] if clocks else None
        self._leader = self._recorded_clock or _busiest(ports)
        self._clock_name = prefix + (self._recorded_clock or _clock_beside(self._leader))
        self._clock: ClockServer | None = None
        if self._recorded_clock is not None:
            self._clock = ClockServer(node, self._clock_name)
        self._decode = Decoder(Clock).decode
        self._time, self._state = -1, "running"
        player.serve(node, lambda: {"refused": self.refused})

    def spin(self) -> None:
        """Write what is due, then wait for what is due next, or for a request."""
        for _ in range(BURST):
            item = self._player.next()
            if item is None:
                break
            self._play(item)
        self._tell_time()
        remaining = self._player.remaining
        self._node.wait(IDLE if remaining is None else min(remaining, IDLE))

    def _play(self, item: Item) -> None:
        if item.message.type != self._types[item.port]:
            self.refused += 1
            return
        if item.port == self._leader:
            self._follow(item)
        if (output := self._outputs.get(item.port)) is not None:
            output.play(item.message)

    def _follow(self, item: Item) -> None:
        """Take the simulated time from the recorded clock, or from the busiest port's stamps."""
        message = item.message
        if self._recorded_clock is not None:
            try:
                clock = self._decode(item.data)[0]
            except WireError:
                return
            self._time, self._state = clock.time, clock.state
        elif message.clock == SIMULATED:
            self._time = message.stamp
            if self._clock is None:
                self._clock = ClockServer(self._node, self._clock_name)
        self._tell_time()

    def _tell_time(self) -> None:
        if self._clock is not None and self._time >= 0:
            paused = self._player.paused or self._state == "paused"
            state: State = "paused" if paused else "running"
            self._clock.update(self._time, state)


def _busiest(ports: dict[str, Port]) -> str:
    return max(ports, key=lambda name: ports[name].count, default="/none:o")


def _clock_beside(name: str) -> str:
    """The usual name of the clock of the robot to which a port belongs."""
    return f"/{name.split('/')[1]}/clock:o"
