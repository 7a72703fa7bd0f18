"""An output that writes recorded bytes under a head of its own."""

from typing import Any

from bus.errors import WireError
from bus.node import Node
from bus.output import Output, Times
from bus.recording.heads import Recorded, head_of, join
from bus.recording.reader import Port
from bus.session import MAX_MESSAGE
from bus.stream import Stream


class RawOutput(Output):
    """Owns a name as any output does; readers follow its own source, epoch and sequence."""

    def stand(self) -> None:
        """The name is ours."""
        super().stand()
        self._head = head_of(self.type_name, self.source, self.epoch)

    def play(self, message: Recorded) -> None:
        """Write a recorded message: measurement, validity and data as they were, sent now."""
        stamp, clock, acquired, _, valid, tail, _ = message
        self.write(tail, stamp=stamp, clock=clock, acquired=acquired, valid=valid)

    def _encode(self, stream: Stream, data: Any, times: Times, valid: bool, reason: str) -> bytes:
        message = join(self._head, stream.seq + 1, *times, data)
        if len(message) > MAX_MESSAGE:
            raise WireError(f"{self.name}: {len(message)} bytes, limit {MAX_MESSAGE}")
        return message


def open_raw_output(node: Node, name: str, port: Port) -> RawOutput:
    """Open a recorded port under a name of ours; one ending in ``:i`` writes to that input."""
    output = RawOutput(node.session, name, port.message_type(), port.nominal_hz)
    if output.owned:
        node.ports.check_free(name)
        node.ports.add(output)
    else:
        output.stand()
    return output
