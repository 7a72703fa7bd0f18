"""What the latency test sends, and where."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np

PING, PONG = "ping:o", "pong:o"
RAW_PING, RAW_PONG = "latency/raw/ping", "latency/raw/pong"  # below the asker's name


@dataclass(frozen=True, eq=False, kw_only=True)
class Payload:
    """Numbers without a meaning."""

    TYPE: ClassVar[str] = "LatencyPayload/1"
    values: np.ndarray = field(metadata={"shape": ("n",), "dtype": "float64", "unit": "1"})
