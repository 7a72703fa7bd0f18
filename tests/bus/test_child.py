"""What a child takes before it becomes its module."""

import os
import subprocess

import bus
from bus import child


def test_realtime_is_the_lowest_of_the_fixed_priorities(monkeypatch):
    taken = []
    monkeypatch.setattr(os, "sched_setscheduler", lambda *given: taken.append(given))
    child.take("realtime")
    ((pid, policy, parameters),) = taken
    assert (pid, policy, parameters.sched_priority) == (0, os.SCHED_FIFO, 1)


def test_where_realtime_is_not_permitted_the_child_goes_on_without(monkeypatch):
    def refuse(*_):
        raise PermissionError

    monkeypatch.setattr(os, "sched_setscheduler", refuse)
    child.take("realtime")


def test_any_other_priority_is_a_niceness(monkeypatch):
    given = []
    monkeypatch.setattr(os, "nice", given.append)
    child.take("5")
    assert given == [5]


def test_a_folder_called_as_a_package_of_ours_is_not_taken_for_it_and_own_modules_are_found(
    tmp_path,
):
    for name in "bus", "services":
        (tmp_path / name).mkdir()
    (tmp_path / "bus" / "__init__.py").write_text("raise RuntimeError('not ours')")
    (tmp_path / "mine.py").write_text("import sys, bus; print(bus.__file__, sys.argv[1])")
    run = child.command("mine", "told")
    printed = subprocess.run(run, cwd=tmp_path, check=True, capture_output=True, text=True).stdout
    assert printed.split() == [bus.__file__, "told"]
