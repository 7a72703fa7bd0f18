"""A process on the bus always ends: no thread of the bus may hold it."""

import signal
import subprocess
import sys
import time
from pathlib import Path

import pytest

from bus.testing import Process, eventually

SOON = 9.0  # s on a loaded machine, usually 0.2; Zenoh alone lingers for 10 where a peer is stopped
WITHIN = 60.0  # s, start-up on a loaded machine included; a hang is for ever


def run(case, endpoint):
    process = subprocess.Popen(
        [sys.executable, "-m", "tests.bus.exits", case, endpoint],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
    )
    assert process.stdout is not None
    assert process.stdout.readline() == "ready\n", process.communicate()
    return process


def finish(process, case):
    try:
        _, errors = process.communicate(timeout=WITHIN)
    except subprocess.TimeoutExpired:
        process.kill()
        pytest.fail(f"{case} hangs: {process.communicate()}")
    return process.returncode, errors


@pytest.mark.parametrize(
    ("case", "status", "error"),
    [
        ("falls_off_main", 0, ""),
        ("in_a_with_statement", 0, ""),
        ("sys_exit", 3, ""),
        ("unhandled_exception", 1, "LookupError: on purpose"),
        ("unhandled_exception_in_with", 1, "LookupError: on purpose"),
        ("closed_twice", 0, ""),
        ("closed_in_another_thread", 0, ""),
        ("two_nodes_forgotten", 0, ""),
        ("keyboard_interrupt", -signal.SIGINT, "KeyboardInterrupt"),
        ("signal_in_a_call", 1, "asked to end while waiting for /ending/extra/rpc:i"),
        ("daemon_thread_reads", 0, ""),
        ("looks_for_a_lost_peer", 0, ""),
        ("writes_until_the_end", 0, ""),
        ("without_a_hub", 1, "no hub at tcp/127.0.0.1:9 answered within 0.3 s"),
    ],
)
def test_a_process_ends_by_itself(hub, case, status, error):
    returned, errors = finish(run(case, hub), case)
    assert (returned, error in errors) == (status, True), errors
    assert error or not errors


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT], ids=["SIGTERM", "SIGINT"])
@pytest.mark.parametrize(
    "case", ["waits_for_a_signal", "waits_for_a_signal_without_with", "sleeps_on_a_signal"]
)
def test_a_process_ends_with_zero_on_a_signal(hub, case, number):
    process = run(case, hub)
    began = time.monotonic()
    process.send_signal(number)
    assert finish(process, case) == (0, "")
    assert time.monotonic() - began < SOON


def test_a_signal_ends_the_wait_for_a_hub(hub):
    process = run("stopped_before_ready", hub)
    process.send_signal(signal.SIGTERM)
    status, errors = finish(process, "stopped_before_ready")
    assert status == 1 and "asked to end before the hub answered" in errors


def test_a_process_ends_although_a_peer_is_stopped(hub, start):
    toy = start("tests.bus.toys", service="toy")
    process = run("waits_for_a_signal", hub)
    toy.send(signal.SIGSTOP)
    began = time.monotonic()
    process.send_signal(signal.SIGTERM)
    assert finish(process, "beside a stopped peer") == (0, "")
    assert time.monotonic() - began < SOON


@pytest.mark.parametrize("number", [signal.SIGTERM, signal.SIGINT], ids=["SIGTERM", "SIGINT"])
def test_a_service_ends_with_zero_while_it_starts(hub, number):
    """At any time from the first line of serve on."""
    for delay in (0.0, 0.02, 0.1):
        process = Process("tests.bus.toys", "--connect", hub, "--log-level", "debug")
        eventually(lambda p=process: p.popen.poll() is not None or _catches_sigterm(p.pid), 60.0)
        time.sleep(delay)
        assert process.stop(number) == 0, process.output
        process.clean_up()


def _catches_sigterm(pid):
    caught = Path(f"/proc/{pid}/status").read_text().partition("SigCgt:")[2].split()[0]
    return int(caught, 16) & 1 << (signal.SIGTERM - 1)


def test_a_service_ends_although_leaving_the_bus_hangs(start):
    stuck = start("tests.bus.stuck", service="stuck")
    assert stuck.stop() == 0
    assert "leaving the bus takes too long" in stuck.output
