"""Message types for the tests of the bus; nothing of a robot."""

from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np


def array(*shape: str | int, **more: Any) -> Any:
    """Declare a float64 field."""
    metadata = {"shape": shape, "dtype": "float64", "unit": "N m", "frame": "", **more}
    return (
        field(metadata=metadata, default=None) if more.get("optional") else field(metadata=metadata)
    )


@dataclass(frozen=True, eq=False, kw_only=True)
class Number:
    """One number."""

    TYPE: ClassVar[str] = "Number/1"
    value: float = field(metadata={"unit": "m"})


@dataclass(frozen=True, eq=False, kw_only=True)
class Mixed:
    """Every kind of field."""

    TYPE: ClassVar[str] = "Mixed/1"
    q: np.ndarray = array("n")
    ft: np.ndarray = array("k", 6)
    extra: np.ndarray | None = array("n", optional=True)
    ok: np.ndarray = field(metadata={"shape": ("n",), "dtype": "bool"})
    name: str = "arm"
    count: int = 3
    delay: float = 0.0
    on: bool = True
    tags: list[str] = field(default_factory=list)
    maps: list[dict[str, Any]] = field(default_factory=list)
    maybe: str | None = None


@dataclass(frozen=True, eq=False, kw_only=True)
class Picture:
    """One byte per pixel, row by row."""

    TYPE: ClassVar[str] = "Picture/1"
    height: int
    width: int
    pixels: bytes


def mixed(n: int = 3, k: int = 2, **more: Any) -> Mixed:
    """Return a message with n joints and k sensors."""
    values = {
        "q": np.arange(n, dtype=float),
        "ft": np.arange(6.0 * k).reshape(k, 6),
        "ok": np.array([i % 2 == 0 for i in range(n)]),
    }
    return Mixed(**{**values, **more})


MS = 1_000_000  # ns


def write(out, stamps, **more) -> None:
    """Write a number for each simulated stamp [ns]: its milliseconds."""
    for stamp in stamps:
        out.write(Number(value=stamp / MS), stamp=stamp, clock=1, **more)
