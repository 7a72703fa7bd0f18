"""The page as a process, without a browser."""

import socket
import urllib.request

import pytest

from bus import RpcError
from bus.testing import Process, eventually

pytestmark = pytest.mark.system


def end_of(process: Process) -> int:
    """Return the exit status of a process that ends by itself."""
    return process.popen.wait(20.0)


def test_status_tells_the_address_and_the_address_answers(start, node):
    process = start("dashboard")
    url = node.call("/dashboard/rpc:i", "status")["url"]
    with urllib.request.urlopen(url, timeout=60) as answer:
        assert b"<html" in answer.read()
    assert f"dashboard: {url}\n" in eventually(lambda: process.output)


def test_a_simulation_is_asked_to_make_room_for_a_browser_that_loads_the_page(start, node):
    asked: list[float] = []
    node.rpc("/icub/sim/rpc:i", {"slow_down": lambda seconds: asked.append(seconds)})
    node.ready()
    start("dashboard", "--set", "makes_room=true")
    url = node.call("/dashboard/rpc:i", "status")["url"]
    assert not asked
    with urllib.request.urlopen(url, timeout=60) as answer:
        answer.read()  # as a browser does
    eventually(lambda: node.wait(0.01) or len(asked) > 2)
    assert all(0.0 < seconds <= 2.0 for seconds in asked)


def test_busy_port_ends_the_process_with_one_line_that_names_the_holder(hub):
    with socket.create_server(("127.0.0.1", 0)) as taken:
        port = taken.getsockname()[1]
        process = Process("dashboard", "--connect", hub, "--set", f"port={port}")
        try:
            assert end_of(process) == 1
            assert process.output.count("\n") == 1
            assert f"port {port} of 127.0.0.1 is taken by pid " in process.output
        finally:
            process.clean_up()


def test_address_that_others_can_reach_is_refused(hub):
    process = Process("dashboard", "--connect", hub, "--set", "host=0.0.0.0")
    try:
        assert end_of(process) == 2
        assert "loopback" in process.output
    finally:
        process.clean_up()


def test_setting_that_would_have_no_effect_is_refused(start, node):
    start("dashboard")
    change = {"action": "set", "name": "scene_rate", "value": 5.0}
    with pytest.raises(RpcError, match="scene_rate: cannot change"):
        node.call("/dashboard/rpc:i", "param", change)
    node.call("/dashboard/rpc:i", "param", {"action": "set", "name": "support", "value": "pole"})
