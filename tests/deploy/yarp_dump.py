"""Folders as yarpdatadumper writes them, after its public description.

``python -m tests.deploy.yarp_dump DIR`` writes some.
"""

import sys
from collections.abc import Callable
from pathlib import Path

import yaml

MAP = Path(__file__).parents[2] / "docs" / "yarp_map.yaml"
START = 1_600_000_000.0  # s
STATE, ANALOG, INERTIAL = 0.01, 0.01, 0.02  # s
SECONDS = 1.0
Values = Callable[[float], str]


def write_dump(folder: Path, stamp: str = "") -> Path:
    """Write all streams of the map in docs/.

    Joint j of a part stands at ``5 j + t`` degrees, wrench component i reads ``i + t``, and the
    gyro ``9 t`` deg/s, with t in seconds since the start: straight lines all.
    """
    for stream in yaml.safe_load(MAP.read_text())["streams"]:
        source = stream["source"]
        name = source.strip("/").replace("/", "_").replace(":", "_")
        if "q" in stream:
            width = 16 if "arm" in source else 6
            write_stream(folder / name, source, STATE, lambda t, w=width: state(t, w), stamp)
        elif "ft" in stream:
            write_stream(folder / name, source, ANALOG, analog, stamp, offset=0.004)
        else:
            write_stream(folder / name, source, INERTIAL, inertial, stamp, offset=-0.005)
    return folder


def write_stream(
    folder: Path, port: str, period: float, values: Values, stamp: str = "", offset: float = 0.0
) -> None:
    """Write one folder; ``stamp`` is what its info.log says of the stamps."""
    folder.mkdir(parents=True)
    info = f"Type: Bottle;\n{stamp}[{START:.6f}] {port} [connected]\n"
    (folder / "info.log").write_text(info)
    lines = []
    for number in range(round(SECONDS / period) + 1):
        t = number * period + offset
        received = f" {START + t + 0.5:.6f}" if "tx+rx" in stamp else ""
        lines.append(f"{number + 7} {START + t:.6f}{received} {values(t)}")
    (folder / "data.log").write_text("\n".join(lines) + "\n")


def state(t: float, width: int) -> str:
    """Encoders, degrees."""
    return " ".join(f"{5.0 * j + t:.17g}" for j in range(width))


def analog(t: float) -> str:
    """Force and moment."""
    return " ".join(f"{i + t:.17g}" for i in range(6))


def inertial(t: float) -> str:
    """Angles, acceleration, angular velocity, compass."""
    return f"0 0 0 0 0 9.81 {9.0 * t:.17g} 0 0 1 2 3"


if __name__ == "__main__":
    write_dump(Path(sys.argv[1]))
