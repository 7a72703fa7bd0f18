"""Finding the bus, and refusing to leave the machine."""

import os
import subprocess
import sys

import pytest

from bus import BusError, Node, runtime_directory
from bus.session import LOOPBACK, check_local, is_local, where_to_listen


@pytest.fixture(autouse=True)
def empty(tmp_path, monkeypatch):
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path))
    monkeypatch.delenv("WRENCHBUS_CONNECT", raising=False)


@pytest.fixture
def other():
    """Another live process's pid."""
    process = subprocess.Popen([sys.executable, "-c", "input()"], stdin=subprocess.PIPE)
    yield process.pid
    process.communicate()


def announce_as(pid, endpoint, monkeypatch):
    with monkeypatch.context() as patch:
        patch.setattr(os, "getpid", lambda: pid)
        return runtime_directory.announce(endpoint)


def test_a_place_that_cannot_be_written_is_named_with_what_to_set(tmp_path, monkeypatch):
    (tmp_path / "file").touch()
    monkeypatch.setenv("XDG_RUNTIME_DIR", str(tmp_path / "file"))
    with pytest.raises(BusError, match="file/wrenchbus: Not a directory; .* set XDG_RUNTIME_DIR"):
        runtime_directory.announce("tcp/127.0.0.1:9")


def test_the_live_entry_is_found():
    file = runtime_directory.announce("tcp/127.0.0.1:9", "robot1", "http://127.0.0.1:1")
    entry = runtime_directory.find()
    assert (entry.endpoint, entry.namespace, entry.pid) == (
        "tcp/127.0.0.1:9",
        "robot1",
        os.getpid(),
    )
    assert runtime_directory.resolve(None) == ("tcp/127.0.0.1:9", "robot1")
    runtime_directory.remove(file)
    assert runtime_directory.entries() == []


def test_nothing_running_says_how_to_start(tmp_path):
    with pytest.raises(BusError, match="no bus is running: nothing in .*wrenchbus demo"):
        runtime_directory.find()


def test_entries_of_dead_processes_are_ignored(monkeypatch):
    process = subprocess.Popen([sys.executable, "-c", ""])
    process.wait()
    announce_as(process.pid, "tcp/127.0.0.1:1", monkeypatch)
    runtime_directory.announce("tcp/127.0.0.1:2")
    assert runtime_directory.find().endpoint == "tcp/127.0.0.1:2"


def test_unreadable_entries_are_ignored():
    runtime_directory.announce("tcp/127.0.0.1:2")
    for number, text in enumerate(["", "[]", "{", '{"endpoint": 1}', '{"pid": "x"}']):
        (runtime_directory.directory() / f"{number}.json").write_text(text)
    assert len(runtime_directory.entries()) == 1


def test_several_live_buses_are_listed(monkeypatch, other):
    runtime_directory.announce("tcp/127.0.0.1:1")
    announce_as(other, "tcp/127.0.0.1:2", monkeypatch)
    with pytest.raises(BusError, match=r"several buses.*:1 \(pid .*:2 \(pid .*--connect"):
        runtime_directory.find()


def test_the_environment_and_the_argument_win(monkeypatch):
    runtime_directory.announce("tcp/127.0.0.1:1", "one")
    monkeypatch.setenv("WRENCHBUS_CONNECT", "tcp/127.0.0.1:2")
    assert runtime_directory.resolve(None) == ("tcp/127.0.0.1:2", "")
    assert runtime_directory.resolve("tcp/127.0.0.1:1") == ("tcp/127.0.0.1:1", "one")


@pytest.mark.parametrize(
    ("endpoint", "local"),
    [
        ("tcp/127.0.0.1:7512", True),
        ("tcp/localhost:1", True),
        ("tcp/[::1]:1", True),
        ("unixsock-stream//tmp/x", True),
        ("tcp/0.0.0.0:7512", False),
        ("tcp/[::]:7512", False),
        ("tls/robot.local:7447", False),
        ("udp/192.168.0.1:1", False),
    ],
)
def test_endpoints_that_leave_the_machine_are_told_apart(endpoint, local):
    assert is_local(endpoint) == local


def test_an_unprotected_endpoint_of_another_machine_is_refused():
    with pytest.raises(BusError, match="leaves this machine.*--insecure"):
        Node("x", connect="tcp/192.0.2.1:7512", signals=False)


@pytest.mark.parametrize("endpoint", ["nonsense", "127.0.0.1:7512", "tcp/127.0.0.1", "tcp/h:x"])
def test_what_is_no_endpoint_is_told_from_one_that_leaves_the_machine(endpoint):
    with pytest.raises(BusError, match=f"bad endpoint '{endpoint}': expected such as tcp/127"):
        check_local([endpoint], insecure=True)


@pytest.mark.parametrize("endpoint", ["tcp/[::1]:7512", "tcp/h:7512#iface=eth0", "unixpipe/tmp/x"])
def test_all_kinds_of_endpoints_are_let_through_where_that_is_allowed(endpoint, monkeypatch):
    monkeypatch.setattr("bus.session._unprotected", [])
    check_local([endpoint], insecure=True)


def test_only_who_may_leave_the_machine_listens_where_others_reach_it():
    assert where_to_listen("tcp/127.0.0.1:7512", insecure=True) == LOOPBACK
    assert where_to_listen("tcp/192.0.2.1:7512", insecure=False) == LOOPBACK
    assert where_to_listen("tls/192.0.2.1:7512", insecure=True) == LOOPBACK
    # reached from the loopback, though it says more
    assert where_to_listen("tcp/0.0.0.0:7512", insecure=True) == "tcp/127.0.0.1:0"
