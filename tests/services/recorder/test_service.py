"""The recorder as a process: asked over RPC, killed, stopped, on a full disk."""

import json
import resource
import signal

import psutil
import pytest

from bus import RpcError
from bus.recording import Recording, RecordingError
from bus.recording.repair import repair
from bus.testing import eventually

PORT = "/source/out:o"
FLUSH = 0.2  # s
LAST = 2  # messages that were written, and may not have come when the recording ended


@pytest.fixture
def folder(tmp_path):
    return tmp_path / "recordings"


@pytest.fixture
def recorder(start, folder):
    """A recorder beside somebody who writes."""
    start("tests.bus.source", "--set", "rate=500")
    return start("services.recorder", "--set", f"folder={folder}", "--set", f"flush={FLUSH}")


@pytest.fixture
def ask(recorder, node):
    """Return ``ask(verb, **arguments)``: the recorder's answer."""
    node.ready()
    return lambda verb, **arguments: node.call("/recorder/rpc:i", verb, arguments, timeout=20.0)


def recorded(ask):
    """Return how many messages of the source are recorded."""
    return ask("status")["ports"].get(PORT, {}).get("recorded", 0)


def missing(recording):
    """Return how many messages of the source a recording has not, by their numbers."""
    numbers = [m.envelope.seq for m in recording.messages([PORT])]
    return numbers[-1] - numbers[0] + 1 - len(numbers)


def ended(ask):
    """Wait until nothing is recorded any more; return the status."""
    eventually(lambda: not ask("status")["recording"])
    return ask("status")


def test_start_status_and_stop_make_a_recording_with_all_that_belongs_to_it(ask, folder):
    assert ask("status")["recording"] is False
    began = ask("start", file="walk")
    assert began["file"] == str(folder / "walk.mcap") and began["recording"] is True
    eventually(lambda: recorded(ask) > 200)
    eventually(lambda: ask("status")["size"] > 10_000)
    ended = ask("stop")
    assert ended["recording"] is False and ended["seconds"] > 0
    recording = Recording(folder / "walk.mcap")
    assert missing(recording) <= ended["ports"][PORT]["lost"] <= missing(recording) + LAST
    assert recording.ports[PORT].count == ended["ports"][PORT]["recorded"] > 200
    about = recording.metadata["recording"]
    assert {"version", "python", "host", "cpu", "kernel", "command"} <= about.keys()
    assert recording.metadata["robot"] == {"name": "icub", "model": "6b2b7b79"}
    assert json.loads(recording.attachments["config/source.json"]) == {"rate": 500.0}
    assert b"<robot" in recording.attachments["robot/icub.urdf"]
    assert b"joints:" in recording.attachments["robot/icub.yaml"]


def test_what_makes_no_sense_is_refused_and_changes_nothing(ask, folder):
    with pytest.raises(RpcError, match="nothing is being recorded"):
        ask("stop")
    for name in ("../walk", "/tmp/walk.mcap", ".hidden"):
        with pytest.raises(RpcError, match="expected a plain name"):
            ask("start", file=name)
    with pytest.raises(RpcError, match="bad port name"):
        ask("start", file="walk", ports=["torques"])
    ask("start", file="walk", ports=[PORT])
    with pytest.raises(RpcError, match=r"recording .*walk\.mcap already"):
        ask("start", file="other")
    ask("stop")
    with pytest.raises(RpcError, match=r"walk\.mcap exists already"):
        ask("start", file="walk")
    assert [file.name for file in folder.iterdir()] == ["walk.mcap"]


def test_sigterm_finishes_the_file(ask, recorder, folder):
    ask("start", file="walk", ports=[PORT])
    eventually(lambda: recorded(ask) > 100)
    recorder.stop()
    assert Recording(folder / "walk.mcap").ports[PORT].count > 100


def test_what_a_killed_recorder_had_flushed_is_rescued(ask, recorder, folder, tmp_path):
    ask("start", file="walk")
    eventually(lambda: recorded(ask) > 300)
    before, size = recorded(ask), ask("status")["size"]
    eventually(lambda: ask("status")["size"] > size and recorded(ask) > before + 500)
    recorder.kill()
    with pytest.raises(RecordingError, match="not finished, cut at byte"):
        Recording(folder / "walk.mcap")
    done = repair(folder / "walk.mcap", tmp_path / "new.mcap")
    rescued = [m.envelope.seq for m in Recording(tmp_path / "new.mcap").messages([PORT])]
    assert len(rescued) >= before  # a second ago, five times the time of a flush
    assert rescued == list(range(rescued[0], rescued[0] + len(rescued)))
    assert done.nameless == 0


def test_a_full_disk_ends_the_recording_with_an_error_and_nothing_else(
    ask, recorder, folder, tmp_path
):
    limits = psutil.Process(recorder.pid).rlimit(resource.RLIMIT_FSIZE)
    ask("start", file="walk", ports=[PORT])
    eventually(lambda: recorded(ask) > 100)
    psutil.Process(recorder.pid).rlimit(resource.RLIMIT_FSIZE, (200_000, limits[1]))
    told = ended(ask)
    assert "walk.mcap: File too large; recording stopped after" in told["error"]
    assert "log repair" in told["error"]
    assert repair(folder / "walk.mcap", tmp_path / "new.mcap").messages > 100
    psutil.Process(recorder.pid).rlimit(resource.RLIMIT_FSIZE, limits)
    assert ask("start", file="again", ports=[PORT])["error"] == ""
    eventually(lambda: recorded(ask) > 10)
    ask("stop")


def test_too_little_space_finishes_the_file_and_little_space_is_a_warning(ask, folder):
    ask("param", action="set", name="low_space", value=1e18)
    assert ask("start", file="walk", ports=[PORT])["recording"]
    eventually(lambda: "MB left" in ask("status")["warning"])
    ask("stop")
    ask("param", action="set", name="least_space", value=1e18)
    ask("start", file="again", ports=[PORT])
    told = ended(ask)
    assert "stopped and finished, the disk has" in told["error"]
    assert Recording(folder / "again.mcap").ports is not None


def test_what_a_suspended_recorder_misses_is_counted(ask, recorder, folder, node):
    ask("start", file="walk", ports=[PORT])
    eventually(lambda: recorded(ask) > 100)
    first = node.call("/source/rpc:i", "status")["uptime_s"]
    recorder.send(signal.SIGSTOP)
    eventually(lambda: node.call("/source/rpc:i", "status")["uptime_s"] > first + 4.0)
    recorder.send(signal.SIGCONT)
    count = eventually(lambda: _answers(ask))
    eventually(lambda: recorded(ask) > count + 100)
    losses = ask("stop")["ports"][PORT]
    recording = Recording(folder / "walk.mcap")
    assert missing(recording) <= losses["lost"] <= missing(recording) + LAST
    assert losses["recorded"] == recording.ports[PORT].count


def _answers(ask):
    try:
        return recorded(ask)
    except RpcError:
        return 0
