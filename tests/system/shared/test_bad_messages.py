"""Rubbish on every input port of the running system changes nothing but a counter."""

import time
from typing import Any

import msgpack
import pytest
import zenoh

from bus import BusError
from bus.introspection import list_ports, port_info
from tests.system.forgery import bad_messages
from tests.system.stack import PATIENCE, Stack

pytestmark = [pytest.mark.system, pytest.mark.timeout(300)]
BURST = 20  # messages; lasts longer than the periods at which slow readers look


def names(stack: Stack, direction: str) -> list[str]:
    """Return the ports of the live system, without the observer's own."""
    ports = list_ports(stack.node)
    return [
        port["name"]
        for port in ports
        if port["direction"] == direction and port["owner"]["service"] != "observer"
    ]


def info(stack: Stack, name: str) -> dict[str, Any]:
    """Return a port's information; on a loaded machine a link may be lost and come back."""

    def complete() -> dict[str, Any] | None:
        try:
            told = port_info(stack.node, name)
        except BusError:
            return None
        return told if "statistics" in told else None

    return stack.until(complete, lambda: f"no information on {name}")


def count(stack: Stack, name: str, kind: str) -> int:
    return info(stack, name)["statistics"][kind]


def send_until_refused(stack: Stack, bad: dict[str, bytes], what: str) -> None:
    """Send a message to each port again and again: in a queue of one, a good one may replace it
    unread."""
    before = {name: count(stack, name, "refused") for name in bad}
    deadline = time.monotonic() + PATIENCE
    while bad:
        assert time.monotonic() < deadline, f"{', '.join(bad)} does not refuse {what}"
        for name, payload in bad.items():
            for _ in range(BURST):
                stack.node.session.put(name[1:], payload)
        bad = {n: p for n, p in bad.items() if count(stack, n, "refused") == before[n]}


def test_every_input_refuses_what_is_not_its_message_and_everything_goes_on(stack: Stack):
    robot = stack.robot
    inputs = names(stack, "input")
    pids = stack.pids
    bad = {n: bad_messages(info(stack, n), robot.dimensions, robot.model_hash) for n in inputs}
    for what in sorted({what for each in bad.values() for what in each}):
        send_until_refused(stack, {n: each[what] for n, each in bad.items() if what in each}, what)
    assert len(inputs) >= len(stack.processes)
    assert stack.pids == pids
    stack.assert_running()
    stack.await_whole()
    assert not stack.ask("sensor_server", "status")["holding"]


@pytest.mark.parametrize("size", [5_000_000, 20_000_000])
def test_a_huge_message_harms_nobody(stack: Stack, size: int):
    for name in names(stack, "input"):
        if name.endswith("/sensors:i"):
            stack.node.session.put(name[1:], bytes(size))
    stack.assert_running()
    stack.await_whole()


@pytest.mark.parametrize(
    "payload",
    [b"", b"\xc1garbage", msgpack.packb(["status"]), msgpack.packb([1, {}]), bytes(300_000)],
    ids=["nothing", "garbage", "no arguments", "no verb", "oversized"],
)
def test_every_rpc_port_answers_rubbish_with_an_error(stack: Stack, payload: bytes):
    def errors(name: str) -> list[bool]:
        target = zenoh.QueryTarget.ALL
        get = stack.node.session.get
        replies = get(name[1:], payload=payload, timeout=10.0, target=target)
        return [reply.err is not None for reply in replies]

    for name in names(stack, "rpc"):
        answer = stack.until(lambda name=name: errors(name), lambda name=name: f"{name} is mute")
        assert all(answer), name  # twice, where a link has just been made anew
    stack.assert_running()
