"""Recording everything that the demo publishes: losses, processor time, bytes per minute.

``python -m benchmarks.bench_recording --minutes 10`` prints the figures of a long run.
"""

import argparse
import tempfile
import time
from pathlib import Path
from typing import Any

from benchmarks.bench_system import within
from benchmarks.load import processor_seconds
from benchmarks.running_demo import RunningDemo, running_demo
from bus.recording import Recording

SECONDS, QUICK = 60.0, 10.0
SETTLED = 8.0  # [s] after the start: the tare is done, the first push comes
RECORDER = "/recorder/rpc:i"
SENSORS = "/icub/sensors:o"

Row = dict[str, Any]


def run(quick: bool = False) -> list[Row]:
    """Return the figures of a recording beside the demo, each with its target."""
    return measure(QUICK if quick else SECONDS)


def measure(seconds: float) -> list[Row]:
    """Record the demo for so many seconds of wall time."""
    with tempfile.TemporaryDirectory() as folder, running_demo("--no-browser") as demo:
        time.sleep(SETTLED)
        without = _cores(demo, min(seconds, SECONDS) / 2)
        ask = {"action": "set", "name": "folder", "value": folder}
        demo.node.call(RECORDER, "param", ask)
        slipped = _slipped(demo)
        demo.node.call(RECORDER, "start", {"file": "demo"}, timeout=20.0)
        beside = _cores(demo, seconds)
        told = demo.node.call(RECORDER, "stop", timeout=60.0)
        slipped = _slipped(demo) - slipped
        frames = Recording(Path(folder, "demo.mcap")).ports[SENSORS].count
    return _flow(told, frames, slipped) + _processor(without, beside)


def _cores(demo: RunningDemo, seconds: float) -> dict[str, float]:
    """Return the cores that each process uses, averaged over so many seconds."""
    start = {name: processor_seconds(pid) for name, pid in demo.pids.items()}
    began = time.monotonic()
    time.sleep(seconds)
    elapsed = time.monotonic() - began
    return {n: (processor_seconds(pid) - start[n]) / elapsed for n, pid in demo.pids.items()}


def _slipped(demo: RunningDemo) -> int:
    return demo.node.call("/robot_sim/rpc:i", "status")["slipped_ticks"]


def _flow(told: dict[str, Any], frames: int, slipped: int) -> list[Row]:
    minutes = told["seconds"] / 60.0
    rate = frames / told["seconds"]
    missing = sum(port["unheard"] + port["foreign"] for port in told["ports"].values())
    return [
        _row("recording: duration", told["seconds"], "s"),
        _row("recording: messages", told["messages"], "1"),
        _row("recording: messages lost", told["lost"], "1", told["lost"] == 0, "0"),
        _row("recording: unheard of or foreign", missing, "1", missing == 0, "0"),
        _row("recording: sensor frames", rate, "Hz", within(rate), "1000 +- 1 %"),
        _row("recording: size per minute", told["size"] * 1e-6 / minutes, "MB/min"),
        _row("recording: plant ticks slipped meanwhile", slipped, "1"),
    ]


def _processor(without: dict[str, float], beside: dict[str, float]) -> list[Row]:
    more = sum(beside.values()) - sum(without.values())
    return [
        _row("processor of the recorder, idle", without["recorder"], "cores"),
        _row("processor of the recorder, recording", beside["recorder"], "cores"),
        _row("processor of all together, not recording", sum(without.values()), "cores"),
        _row("processor of all together, recording", sum(beside.values()), "cores"),
        _row("processor that the recording costs all others", more - beside["recorder"], "cores"),
    ]


def _row(name: str, value: float, unit: str, met: bool | None = None, target: str = "") -> Row:
    row: Row = {"name": name, "value": value, "unit": unit}
    return row if met is None else row | {"target": target, "met": met}


def _main() -> None:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.bench_recording")
    parser.add_argument("--minutes", type=float, default=10.0)
    for row in measure(60.0 * parser.parse_args().minutes):
        verdict = "" if "met" not in row else ("  met" if row["met"] else "  missed")
        print(f"{row['name']:<50} {row['value']:>14.4g} {row['unit']}{verdict}")


if __name__ == "__main__":
    _main()
