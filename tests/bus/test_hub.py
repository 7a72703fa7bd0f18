"""What happens when the hub dies, comes late, or comes back."""

import json
import subprocess
import sys
import threading

import pytest

from bus import BusError, NameTaken, Node
from bus.testing import Process, eventually, free_port, start_hub
from bus.wiring import connect
from tests.bus.messages import Number


@pytest.fixture
def own_hub():
    """A hub that the test may kill."""
    endpoint, process = start_hub()
    yield endpoint, process
    process.clean_up()


@pytest.fixture
def two(own_hub):
    """A writer and a reader that are linked."""
    endpoint, _ = own_hub
    with (
        Node("writer", connect=endpoint, signals=False) as writer,
        Node("reader", connect=endpoint, signals=False) as reader,
    ):
        out = writer.output("/w/x:o", Number)
        inp = reader.input("/r/x:i", Number, source="/w/x:o", depth=64)
        writer.ready()
        reader.ready()
        eventually(lambda: out.matched)
        yield out, inp, reader


def flows(out, inp):
    """Write one number and see it come."""
    out.write(Number(value=1.0))
    eventually(lambda: inp.newest(), 30.0, "data after the hub's death")


@pytest.mark.parametrize(
    ("words", "expected"),
    [
        (("--log-level", "loud"), "choose from 'debug', 'info'"),
        (("--listen", "tcp/127.0.0.1:0"), "expected a certain port"),
    ],
)
def test_a_wrong_option_of_the_hub_is_wrong_usage(words, expected):
    done = subprocess.run(
        [sys.executable, "-m", "bus.hub", *words], capture_output=True, text=True, timeout=60
    )
    assert done.returncode == 2 and expected in done.stderr


def test_no_data_stop_when_the_hub_dies(own_hub, two):
    out, inp, reader = two
    flows(out, inp)
    own_hub[1].kill()
    for _ in range(100):
        flows(out, inp)
    assert (inp.statistics.lost, inp.statistics.foreign) == (0, 0)
    assert reader.directory.leader("/w/x:o") == out.source


def test_a_hub_that_comes_back_knows_the_names(own_hub, two):
    out, inp, _ = two
    endpoint, process = own_hub
    process.kill()
    _, again = start_hub(endpoint)
    try:
        with Node("newcomer", connect=endpoint, signals=False) as newcomer:
            # its own settling time is 0 in tests, so wait until the peers have come back to it
            eventually(lambda: len(newcomer.session.info.peers_zid()) >= 2)
            eventually(lambda: newcomer.directory.leader("/w/x:o"))
            newcomer.output("/w/x:o", Number)
            with pytest.raises(NameTaken, match="/w/x:o is taken by writer"):
                newcomer.ready()
        flows(out, inp)
    finally:
        again.clean_up()


def test_a_hub_that_was_killed_still_knows_what_is_connected_for_good(tmp_path):
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    options = ("--listen", endpoint, "--settle", "0", "--no-announce", "--state", str(tmp_path))
    hubs = [Process("bus.hub", *options)]
    try:
        with Node("asker", connect=endpoint, signals=False) as asker:
            asker.ready(timeout=60.0)
            connect(asker, "/w/x:o", "/late/x:i", persist=True)
        hubs[0].kill()
        hubs.append(Process("bus.hub", *options))
        with Node("late", connect=endpoint, signals=False) as late:
            inp = late.input("/late/x:i", Number)
            late.ready(timeout=60.0)
            assert inp.sources == ("/w/x:o",)
    finally:
        for process in hubs:
            process.clean_up()


def test_a_node_waits_for_a_hub_that_comes_late():
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    with Node("early", connect=endpoint, signals=False) as node:
        node.output("/e/x:o", Number)
        waiting = threading.Thread(target=node.ready, kwargs={"timeout": 60.0})
        waiting.start()
        _, process = start_hub(endpoint)
        try:
            waiting.join(60.0)
            assert not waiting.is_alive()
        finally:
            process.clean_up()


def test_without_a_hub_ready_ends_with_an_error():
    with Node("alone", connect=f"tcp/127.0.0.1:{free_port()}", signals=False) as node:
        with pytest.raises(BusError, match="no hub at .* answered within 0.2 s"):
            node.ready(timeout=0.2)


def test_a_hub_announces_itself_and_takes_its_entry_away(tmp_path):
    endpoint = f"tcp/127.0.0.1:{free_port()}"
    environment = {"XDG_RUNTIME_DIR": str(tmp_path)}
    arguments = ("--listen", endpoint, "--namespace", "lab", "--settle", "0")
    process = Process("bus.hub", *arguments, environment=environment)
    try:
        (file,) = eventually(lambda: list((tmp_path / "wrenchbus").glob("*.json")), 60.0)
        entry = json.loads(file.read_text())
        assert (entry["endpoint"], entry["namespace"]) == (endpoint, "lab")
        assert entry["pid"] == process.pid
        assert process.stop() == 0
        assert not file.exists()
    finally:
        process.clean_up()


@pytest.mark.parametrize(
    ("arguments", "complaint"),
    [
        (["--listen", "tcp/0.0.0.0:7512"], "hub: endpoint tcp/0.0.0.0:7512 leaves this machine"),
        (["--listen", "nonsense"], "hub: bad endpoint 'nonsense': expected such as tcp/127"),
    ],
)
def test_a_hub_that_cannot_work_says_why(arguments, complaint):
    command = [sys.executable, "-m", "bus.hub", *arguments]
    result = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert result.returncode == 1
    assert result.stderr.startswith(complaint) and result.stderr.count("\n") == 1


def test_a_second_hub_on_the_same_endpoint_is_refused(own_hub):
    command = [sys.executable, "-m", "bus.hub", "--listen", own_hub[0]]
    result = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert result.returncode == 1 and own_hub[0] in result.stderr
