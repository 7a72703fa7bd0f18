"""Latency of the bus beside raw Zenoh, pyzmq and a raw TCP socket.

Two processes play ping-pong over loopback: a round trip lasts from before the call that sends
until the answer is in the hands of the main thread, decoded; one way is from there to the
message in the hands of the other process. Sizes are those of the payload; the bus adds its
envelope of some 100 bytes. All transports take turns in bursts of one run, in both directions
through the list, so that the machine's changing speed hits all alike. Both processes have
real-time priority where the system permits it, as our control services have. Messages are
paced at 1 kHz (1 MB: 100 Hz), so that every one meets an idle, cold process.

Raw Zenoh has the settings of our sessions and is used in both patterns that receive in the main
thread; ratios are to the faster one. The sensor frame is one of a robot of 32 joints, and its
peer a raw Zenoh payload of the same size, which nobody encodes or decodes. Its target in us was
set where raw Zenoh's one-way time is 14 to 17 us, of which it is one and a half; so on a slower
machine the figure is told in one-way times too.
"""

import os
import time
from collections.abc import Iterator
from contextlib import ExitStack, contextmanager, suppress

import numpy as np

from benchmarks.children import child, hub_process
from benchmarks.pace import Pace, alarm
from benchmarks.rows import Row, percentiles, row
from benchmarks.transports import ENDS, LARGEST, End, FrameEnd
from bus.child import take
from bus.encoder import Encoder
from bus.envelope import new_source
from bus.testing import free_port
from robot_model.messages import SensorFrame

BUS, FRAME, RAW = "the bus", "the bus, sensor frame", ("raw zenoh, recv()", "raw zenoh, callback")
SIZES = {64: "64 B", 512: "512 B", 4096: "4 KB", LARGEST: "1 MB"}
WARM_UP = 5  # first messages of a burst, not counted
BURST = 60  # messages that are counted; with 60 rounds enough for p99.9
Times = dict[tuple[str, int], list[tuple[float, float]]]


def run(quick: bool = False) -> list[Row]:
    """Return one way and round trip of all transports and sizes, and the targets [us]."""
    with real_time(), hub_process() as (hub, _), ExitStack() as stack:
        ends = {name: stack.enter_context(ping_pong(name, hub)) for name in ENDS}
        times = _measure(ends, rounds=6 if quick else 60)
    one_way = _table("one way", times, 0)
    return _targets(times) + one_way + _table("round trip", times, 1)


@contextmanager
def real_time() -> Iterator[None]:
    """Take real-time priority for a while, where permitted; threads started in it keep it."""
    before = os.sched_getscheduler(0), os.sched_getparam(0)
    take("realtime")
    try:
        yield
    finally:
        os.sched_setscheduler(0, *before)


@contextmanager
def ping_pong(transport: str, hub: str) -> Iterator[End]:
    """Start the far end of a transport; return the near one."""
    endpoint = hub if "bus" in transport or "zenoh" in transport else _free_endpoint()
    with child("benchmarks.echo", transport, endpoint, priority="realtime") as far:
        near = ENDS[transport](endpoint, "ping", "pong")
        far.told()
        yield near
        near.close()


def _free_endpoint() -> str:
    return f"tcp/127.0.0.1:{free_port()}"


def _measure(ends: dict[str, End], rounds: int) -> Times:
    plan = [(name, size) for size in SIZES for name in ends if name != FRAME]
    plan += [(name, FRAME_SIZE) for name in (FRAME, *RAW)]
    times: Times = {cell: [] for cell in plan}
    for number in range(rounds):
        for name, size in plan if number % 2 else reversed(plan):
            rate = 100.0 if size == LARGEST else 1000.0
            times[name, size] += _burst(ends[name], size, rate, WARM_UP + BURST)[WARM_UP:]
    return times


def _burst(end: End, size: int, rate: float, count: int) -> list[tuple[float, float]]:
    """Return one way and round trip of some messages [us]; what is lost ends the burst."""
    times = []
    with suppress(TimeoutError), alarm(2.0 + count / rate):
        for start in Pace(rate, count):
            end.send(size, float(start))
            arrived = 0.0
            while arrived < start:  # after a burst that was cut, an old answer may come
                _, arrived = end.receive()
            times.append((1e-3 * (arrived - start), 1e-3 * (time.monotonic_ns() - start)))
    return times


def _targets(times: Times) -> list[Row]:
    ours, raw = _median(times, (BUS, 512)), _raw_median(times, 512)
    frame, same = _median(times, (FRAME, FRAME_SIZE)), _raw_median(times, FRAME_SIZE)
    more = "sensor frame, encoded and decoded, over raw zenoh of its size, per message"
    return [
        row("round trip of 512 B, bus over raw zenoh", ours / raw, "times", limit=1.5, goal=1.25),
        row(more, (frame - same) / 2, "us", limit=25.0, goal=15.0),
        row("the same, in one-way times of raw zenoh", (frame - same) / same, "times"),
        row("the same as a ratio of round trips", frame / same, "times"),
    ]


def _table(what: str, times: Times, column: int) -> list[Row]:
    rows = []
    for name, size in times:
        values = percentiles([pair[column] for pair in times[name, size]])
        label = _label(size)
        for percentile, value in values.items():
            peer = _raw_median(times, size, column) if percentile == "p50" else None
            title = f"{what} of {label}, {name}, {percentile}"
            rows.append(row(title, value, "us", peer=peer, cell=(f"{what} [us]", name, label)))
    return rows


def _median(times: Times, cell: tuple[str, int], column: int = 1) -> float:
    return float(np.median([pair[column] for pair in times[cell]]))


def _raw_median(times: Times, size: int, column: int = 1) -> float:
    """Return the median of the faster pattern of raw Zenoh."""
    return min(_median(times, (name, size), column) for name in RAW)


def _label(size: int) -> str:
    return SIZES.get(size, f"frame ({size} B)")


def _frame_size() -> int:
    """Return the size of an encoded sensor frame [bytes]."""
    frame, _ = FrameEnd.make(0)
    return len(Encoder(SensorFrame, new_source()).encode(frame, 1, 1, 0, 1, 1))


FRAME_SIZE = _frame_size()
