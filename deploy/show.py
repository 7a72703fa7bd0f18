"""Messages as text for people."""

import time
from typing import Any

from bus import Envelope, Received

CLOCKS = ("wall", "simulated")


def message_text(received: Received, envelope: bool = False) -> str:
    """Return the fields of a message, one line each; invalid data are always marked so.

    Args:
        envelope: Begin with sequence number, stamp, age and validity.
    """
    head = received.envelope
    lines = [envelope_text(head)] if envelope else []
    if not head.valid and not envelope:
        lines.append(f"INVALID: {head.reason}")
    for name, field in received.data.__dataclass_fields__.items():
        unit = field.metadata.get("unit", "")
        label = f"{name} [{unit}]" if unit else name
        lines.append(f"  {label}: {_plain(getattr(received.data, name))}")
    return "\n".join(lines)


def envelope_text(envelope: Envelope) -> str:
    """Return sequence number, stamp, age since the measurement and validity on one line."""
    state = "valid" if envelope.valid else f"INVALID: {envelope.reason}"
    age = 1e-6 * (time.time_ns() - envelope.acquired)  # ms
    stamp = f"{1e-9 * envelope.stamp:.6f} s ({CLOCKS[envelope.clock]})"
    return f"seq {envelope.seq}  stamp {stamp}  age {age:.1f} ms  {state}"


def _plain(value: Any) -> str:
    if not hasattr(value, "tolist"):
        return str(value)
    import numpy as np

    shape = "" if value.ndim < 2 else f"{value.shape} "
    flat = np.array2string(value.ravel(), precision=4, max_line_width=10**6, threshold=48)
    return shape + flat
