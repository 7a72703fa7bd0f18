"""What services log is collected over the bus."""

from typing import Any

import pytest

from bus import Node
from bus.clock import ClockServer
from bus.errors import RpcError
from bus.logs import BusLog, LogRecord
from bus.testing import eventually

TOY = "tests.bus.toys"
RPC = "/toy/rpc:i"


def heard(node, inp, level, text):
    """Return a record of a level that holds a text, when it has come."""
    node.wait(0.01)
    while (received := inp.read()) is not None:
        if received.data.level == level and text in received.data.text:
            return received.data
    return None


def test_records_come_over_the_bus_as_they_are_logged(start, node):
    inp = node.input("/test/log:i", LogRecord, source="/toy/log:o", depth=64)
    node.ready()
    start(TOY)

    def crashed():
        with pytest.raises(RpcError, match="no such thing"):
            node.call(RPC, "crash")
        node.call(RPC, "say", {"level": "warning", "text": "it is hot"})
        return heard(node, inp, "warning", "it is hot")

    record = eventually(crashed)
    assert (record.service, record.logger) == ("toy", "tests.bus.toys")


def test_the_last_records_are_told_to_who_comes_late(start, node):
    toy = start(TOY)
    node.ready()
    node.call(RPC, "say", {"level": "info", "text": "early"})
    node.call(RPC, "say", {"level": "debug", "text": "unheard"})
    records = node.call(RPC, "log")
    assert [r["text"] for r in records if r["logger"] == "tests.bus.toys"] == ["early"]
    assert records[-1]["level"] == "info" and records[-1]["time_ns"] > 0
    assert "early" not in toy.output, "standard error keeps its own level"


def test_the_level_is_read_and_set_at_run_time(start, node):
    start(TOY)
    node.ready()
    assert node.call(RPC, "log", {"action": "level"}) == "info"
    assert node.call(RPC, "log", {"action": "level", "value": "debug"}) == "debug"
    node.call(RPC, "say", {"level": "debug", "text": "now heard"})
    assert node.call(RPC, "log")[-1]["text"] == "now heard"
    with pytest.raises(RpcError, match="expected one of debug, info, .* got 'loud'"):
        node.call(RPC, "log", {"action": "level", "value": "loud"})


def test_a_complaint_about_the_clock_stops_nobody(hub):
    with (
        Node("plant", connect=hub, signals=False) as plant,
        Node("led", connect=hub, clock_port="/plant/clock:o", signals=False) as led,
    ):
        clock = ClockServer(plant, "/plant/clock:o")
        BusLog(led)
        plant.ready()
        led.ready()
        clock.update(0)
        eventually(lambda: clock.beat() or led.clock.state == "running")

        def refused() -> int:
            port: Any = led.ports.get("/led/clock:i")
            return port.statistics.refused

        plant.session.put("led/clock:i", b"garbage")
        eventually(lambda: led.wait(0.01) or refused())
        eventually(lambda: clock.update(1000) or led.clock.time == 1000)
