"""What a child takes before it becomes its module."""

import os

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
