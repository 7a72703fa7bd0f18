"""The command among pipes, signals and shells, as a process."""

import os
import signal
import subprocess
import sys

COMMAND = [sys.executable, "-m", "deploy.main"]
OUT = "/toy/out:o"


def shell(script: str, bus: str) -> subprocess.CompletedProcess:
    """Run a script in which ``wrenchbus`` is the command, on a bus."""
    define = f'set -o pipefail; wrenchbus() {{ {" ".join(COMMAND)} "$@"; }}\n'
    return subprocess.run(
        ["bash", "-c", define + script],
        capture_output=True,
        text=True,
        timeout=120,
        env={**os.environ, "WRENCHBUS_CONNECT": bus},
    )


def test_read_into_head_ends_with_0_and_without_a_word(toy_bus):
    done = shell(f"wrenchbus read {OUT} --json | head -1", toy_bus)
    assert (done.returncode, done.stderr) == (0, "") and done.stdout.startswith('{"port"')


def test_read_notices_that_its_reader_went_though_nothing_comes(toy_bus):
    silent = "/hub/log:o"
    done = shell(f"wrenchbus read {silent} | true", toy_bus)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_a_full_disk_is_one_line_and_a_closed_output_is_none(toy_bus):
    done = shell("wrenchbus list > /dev/full", toy_bus)
    assert done.returncode == 1
    assert done.stderr == "wrenchbus: cannot write the output: No space left on device\n"
    done = shell("wrenchbus list >&-; wrenchbus nonsense 2>&-", toy_bus)
    assert (done.returncode, done.stdout, done.stderr) == (2, "", "")


def test_what_is_read_can_be_written_again(toy_bus):
    done = shell(f"wrenchbus read {OUT} -n 3 --json | wrenchbus write /toy/in:i", toy_bus)
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


def test_ctrl_c_ends_a_verb_that_waits_for_input_cleanly(toy_bus):
    arguments = [*COMMAND, "write", "/toy/in:i", "--connect", toy_bus]
    with subprocess.Popen(
        arguments, stdin=subprocess.PIPE, stdout=subprocess.PIPE, stderr=subprocess.PIPE
    ) as writer:
        assert writer.stdin is not None and writer.stderr is not None
        writer.stdin.write(b"value=1\n")
        writer.stdin.flush()
        _until_heard(toy_bus)
        writer.send_signal(signal.SIGINT)
        assert writer.wait(30.0) == 0
        assert writer.stderr.read() == b""


def _until_heard(bus: str) -> None:
    """Return when the toy has written what was typed: then the writer is in its loop."""
    from bus import Node
    from bus.testing import eventually
    from tests.bus.messages import Number

    with Node("listener", connect=bus, signals=False) as node:
        entry = node.input("/listener/in:i", Number, source=OUT, depth=4096)

        def heard() -> bool:
            node.wait(0.05)
            return any(r.envelope.valid for r in iter(entry.read, None))

        eventually(heard)
