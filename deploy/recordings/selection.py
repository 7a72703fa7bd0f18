"""The part of a recording that somebody asked for, decoded."""

from collections.abc import Iterator, Sequence
from typing import Any, NamedTuple

from bus.decoder import Decoder
from bus.envelope import Envelope
from bus.errors import WireError
from bus.names import did_you_mean
from bus.recording import Port, Recording
from deploy.errors import UsageError


class Item(NamedTuple):
    """One decoded message and its arrival at the recorder, wall time [ns]."""

    port: Port
    message: Any
    envelope: Envelope
    arrival: int


class Selection:
    """Some ports of a recording in a range of time.

    Args:
        recording: The recording.
        ports: Names; all ports that have messages when empty.
        start: Seconds after the recording's first message; from there when None.
        end: Seconds after the recording's first message; to the last one when None.

    Raises:
        UsageError: A port is not there, or the range is empty.
    """

    def __init__(
        self,
        recording: Recording,
        ports: Sequence[str] = (),
        start: float | None = None,
        end: float | None = None,
    ):
        known = recording.ports
        for name in ports:
            if name not in known:
                hint = did_you_mean(name, known)
                raise UsageError(f"{recording.path} has no port {name}{hint}")
        if end is not None and end <= (start or 0.0):
            raise UsageError(f"expected --from before --to, got {start or 0.0:g} and {end:g}")
        self._recording = recording
        wanted = [known[name] for name in dict.fromkeys(ports) or known]
        self.ports = [port for port in wanted if port.count]
        self.undecodable: dict[str, int] = {}
        self._start = None if start is None else recording.start + round(start * 1e9)
        self._end = None if end is None else recording.start + round(end * 1e9)

    def items(self, ports: Sequence[Port] | None = None) -> Iterator[Item]:
        """Yield the messages in order of arrival; those that no longer decode are counted."""
        chosen = {port.name: port for port in (self.ports if ports is None else ports)}
        decoders = {name: Decoder(port.message_type()) for name, port in chosen.items()}
        self.undecodable |= dict.fromkeys(chosen, 0)
        if not chosen:
            return
        for name, data, arrival in self._recording.messages(chosen, self._start, self._end):
            try:
                message, envelope = decoders[name].decode(data)
            except WireError:
                self.undecodable[name] += 1
                continue
            yield Item(chosen[name], message, envelope, arrival)
