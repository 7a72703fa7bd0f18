"""The test kit itself."""

import os
import re
import signal

import pytest

from bus.testing import Process, eventually, free_port

pytest_plugins = ["pytester"]


def test_eventually_returns_the_first_true_value():
    values = iter([0, None, "", 7, 8])
    assert eventually(lambda: next(values)) == 7


def test_eventually_fails_with_what_it_waited_for():
    with pytest.raises(AssertionError, match="not within 0.01 s: the moon"):
        eventually(lambda: False, 0.01, "the moon")


def test_a_free_port_is_free():
    assert 1024 < free_port() < 65536


def test_a_process_that_ends_at_once_is_told_with_its_output(start):
    with pytest.raises(AssertionError, match="tests.bus.toys ended with 2:\ntoy: --set"):
        start("tests.bus.toys", "--set", "factor=-1")
    start.processes[-1].expected = 2


def test_clean_up_kills_the_children_too():
    process = Process("tests.bus.parent")
    (child,) = eventually(lambda: re.findall(r"child (\d+)\n", process.output), 60.0)
    process.clean_up()
    eventually(lambda: not _lives(int(child)))


def _lives(pid):
    try:
        os.kill(pid, 0)
        with open(f"/proc/{pid}/stat") as stat:
            return stat.read().rpartition(")")[2].split()[0] != "Z"
    except (ProcessLookupError, FileNotFoundError):
        return False


def test_a_stopped_process_is_continued_and_ends(start):
    toy = start("tests.bus.toys")
    toy.send(signal.SIGSTOP)
    assert toy.popen.poll() is None


def test_a_user_can_test_services_of_his_own(pytester):
    """The plugin in a fresh project: one service that leaves a child and ignores SIGTERM."""
    pytester.makeini("[pytest]\naddopts = -p bus.testing -p no:cacheprovider")
    pytester.makepyfile(
        stubborn="""
        import argparse, signal, time
        from bus import Node
        options = argparse.ArgumentParser()
        options.add_argument("--connect")
        with Node("stubborn", connect=options.parse_args().connect, signals=False) as node:
            signal.signal(signal.SIGTERM, signal.SIG_IGN)
            node.ready()
            print("here I am", flush=True)
            time.sleep(600)
        """,
        test_it="""
        def test_stubborn(start, node):
            process = start("stubborn", service="stubborn")
            print("pid", process.pid)
            assert False
        """,
    )
    result = pytester.runpytest_subprocess("-p", "no:randomly", timeout=120)
    result.assert_outcomes(failed=1, errors=1)
    result.stdout.fnmatch_lines(["*here I am*", "*stubborn did not end within 15*"])
    pid = re.findall(r"^pid (\d+)$", result.stdout.str(), re.MULTILINE)[0]
    assert not _lives(int(pid))
