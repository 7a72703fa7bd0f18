"""The whole demo without a browser: rates, losses, ages, processor time."""

import time
from typing import Any

from benchmarks.load import processor_seconds
from benchmarks.running_demo import running_demo
from bus import Node
from bus.introspection import port_info

SECONDS, QUICK = 60.0, 10.0
SETTLED = 8.0  # [s] after the start: the tare is done, the first push comes
OBSERVER = "/icub/torque_observer/sensors:i"
FRAMES = "/icub/sensors:o"
SENSOR_SERVER = "/sensor_server/rpc:i"

Row = dict[str, Any]


def run(quick: bool = False) -> list[Row]:
    """Return the figures of the demo, each with its target."""
    with running_demo("--no-browser") as demo:
        time.sleep(SETTLED)
        before = Snapshot(demo.node, demo.pids)
        time.sleep(QUICK if quick else SECONDS)
        after = Snapshot(demo.node, demo.pids)
        age = demo.node.call(SENSOR_SERVER, "status")["virtual_torque_age"]
    rows = [_row("demo: start to all services ready", demo.ready_after, "s", 10.0)]
    rows += _flow(before, after)
    rows += [
        _row("age of joint torques at the sensor server, p50", 1e3 * age["p50"], "ms", 1.0),
        _row("age of joint torques at the sensor server, p99", 1e3 * age["p99"], "ms", 5.0),
    ]
    return rows + _processor(before, after)


class Snapshot:
    """Counters and processor times at one instant."""

    def __init__(self, node: Node, pids: dict[str, int]):
        self.time = time.monotonic()
        self.frames = port_info(node, FRAMES)["statistics"]["written"]
        counted = port_info(node, OBSERVER)["statistics"]
        self.received = counted["received"]
        self.missing = counted["lost"] + counted["dropped"]
        self.slipped = node.call("/robot_sim/rpc:i", "status")["slipped_ticks"]
        self.cpu = {name: processor_seconds(pid) for name, pid in pids.items()}


def _flow(before: Snapshot, after: Snapshot) -> list[Row]:
    seconds = after.time - before.time
    rate = (after.frames - before.frames) / seconds
    missing = after.missing - before.missing
    return [
        {**_row("sensor frames", rate, "Hz"), "target": "1000 +- 1 %", "met": within(rate)},
        _row("frames lost at the torque observer", missing, "1", 0.0),
        _row("frames taken by the torque observer", after.received - before.received, "1"),
        _row("plant ticks slipped", after.slipped - before.slipped, "1"),
    ]


def within(rate: float) -> bool:
    """Whether a rate [Hz] is 1 kHz to 1 %."""
    return 990.0 <= rate <= 1010.0


def _processor(before: Snapshot, after: Snapshot) -> list[Row]:
    seconds = after.time - before.time
    cores = {name: (after.cpu[name] - cpu) / seconds for name, cpu in before.cpu.items()}
    rows = [_row(f"processor of {name}", used, "cores") for name, used in cores.items()]
    return [*rows, _row("processor of all together", sum(cores.values()), "cores", 1.3)]


def _row(name: str, value: float, unit: str, limit: float | None = None) -> Row:
    row: Row = {"name": name, "value": value, "unit": unit}
    if limit is not None:
        target = f"<= {limit:g} {unit}".removesuffix(" 1")
        row |= {"target": target, "met": value <= limit}
    return row
