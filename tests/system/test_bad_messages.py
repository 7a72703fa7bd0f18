"""Rubbish on every input port of the running system changes nothing but a counter."""

import msgpack
import pytest
import zenoh

from bus.introspection import list_ports, port_info
from tests.system.forgery import bad_messages
from tests.system.stack import Stack

pytestmark = pytest.mark.system
GOOD_ENOUGH = {"value": b"value", "error": b"error"}


def names(stack: Stack, direction: str) -> list[str]:
    """Return the ports of the live system, without the observer's own."""
    ports = list_ports(stack.node)
    return [
        port["name"]
        for port in ports
        if port["direction"] == direction and port["owner"]["service"] != "observer"
    ]


def refused(stack: Stack, name: str) -> int:
    return port_info(stack.node, name)["statistics"]["refused"]


def test_every_input_refuses_what_is_not_its_message_and_everything_goes_on(stack: Stack):
    robot, session = stack.robot, stack.node.session
    inputs = names(stack, "input")
    pids, states = stack.pids, stack.states()
    before = {name: refused(stack, name) for name in inputs}
    sent = {}
    for name in inputs:
        bad = bad_messages(port_info(stack.node, name), robot.dimensions, robot.model_hash)
        for payload in bad.values():
            session.put(name[1:], payload)
        sent[name] = bad
    assert len(inputs) >= 15
    for name in inputs:
        expected = before[name] + len(sent[name])
        stack.until(
            lambda name=name, expected=expected: refused(stack, name) >= expected,
            lambda name=name, expected=expected: (
                f"{name} refused {refused(stack, name) - before[name]} of {list(sent[name])}"
            ),
        )
    assert stack.pids == pids
    stack.assert_running()
    assert stack.states() == states
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
    for name in names(stack, "rpc"):
        replies = list(
            stack.node.session.get(
                name[1:], payload=payload, timeout=10.0, target=zenoh.QueryTarget.ALL
            )
        )
        assert len(replies) == 1 and replies[0].err is not None, name
    stack.assert_running()
