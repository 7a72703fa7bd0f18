"""A service without a robot, for tests of the command and the launcher.

It writes a message a hundred times a second and answers one verb. As the settings
say, it refuses them (``wrong``) or ignores requests to end (``stubborn``).
"""

import argparse
import json
import signal
import sys
from dataclasses import dataclass, field
from typing import Any, ClassVar

import numpy as np

from bus import Node

POINT = {"shape": (3,), "dtype": "float64", "unit": "m", "frame": "world", "optional": False}
SHADE = {"shape": (2,), "dtype": "float64", "unit": "1", "frame": "", "optional": True}
LIT = {"shape": ("n",), "dtype": "bool", "unit": "", "frame": ""}


@dataclass(frozen=True, eq=False, kw_only=True)
class Light:
    """Where a beacon shines."""

    TYPE: ClassVar[str] = "Light/1"
    point: np.ndarray = field(metadata=POINT)
    lit: np.ndarray = field(metadata=LIT)
    shade: np.ndarray | None = field(metadata=SHADE, default=None)
    colours: list[str] = field(metadata={"unit": ""})


LIGHT = Light(
    point=np.array([1.0, 2.0, 3.0]), lit=np.array([True, False]), colours=["red", "green"]
)


def shine(brightness: float) -> dict[str, float]:
    """Shine as bright as asked."""
    return {"brightness": brightness}


def settings(pairs: list[str]) -> dict[str, Any]:
    """Return the settings of ``--set``."""
    return {key: json.loads(value) for key, _, value in (pair.partition("=") for pair in pairs)}


def main() -> int:
    """Run until asked to end."""
    parser = argparse.ArgumentParser()
    parser.add_argument("--name", default="beacon")
    parser.add_argument("--connect")
    parser.add_argument("--namespace", default="")
    parser.add_argument("--set", action="append", default=[])
    options = parser.parse_args()
    chosen = settings(options.set)
    print(f"settings {json.dumps(chosen)}", flush=True)
    if chosen.get("wrong"):
        print(f"{options.name}: wrong: unknown key", file=sys.stderr)
        return 2
    with Node(options.name, connect=options.connect, namespace=options.namespace) as node:
        light = node.output(f"/{options.name}/light:o", Light, rate=100.0)
        node.verb("shine", shine)
        node.ready()
        if chosen.get("stubborn"):
            signal.signal(signal.SIGTERM, signal.SIG_IGN)
        while node.running:
            node.wait(0.01)
            light.write(LIGHT)
    return 0


if __name__ == "__main__":
    sys.exit(main())
