"""The message that the benchmarks send; it costs no import that they do not need."""

from dataclasses import dataclass, field
from typing import ClassVar

import numpy as np


@dataclass(frozen=True, eq=False, kw_only=True)
class Opaque:
    """A block that nobody looks into."""

    TYPE: ClassVar[str] = "Opaque/1"
    block: np.ndarray = field(metadata={"shape": ("rows", 8), "unit": ""})
