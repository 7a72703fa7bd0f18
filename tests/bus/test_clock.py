"""Simulated time: run, pause, step, reset, absence, lockstep."""

import threading
import time

import pytest

from bus import LockstepTimeout, Node
from bus.clock import SILENCE, ClockServer, SessionClock
from bus.lockstep import Lockstep
from bus.periodic import Periodic
from bus.testing import eventually
from tests.bus.messages import Number

MS = 1_000_000  # ns


@pytest.fixture
def plant(hub):
    with Node("plant", connect=hub, signals=False) as node:
        yield node


@pytest.fixture
def served(plant, hub):
    """A clock server and a node that follows it."""
    server = ClockServer(plant, "/plant/clock:o")
    plant.ready()
    with Node("follower", connect=hub, clock_port="/plant/clock:o", signals=False) as follower:
        follower.ready()
        eventually(lambda: follower.directory.leader("/plant/clock:o"))
        eventually(lambda: server._output.matched)
        yield server, follower


class Beating:
    """Keeps a plant's clock going from another thread, as its loop would."""

    def __init__(self, plant):
        self._plant, self._on = plant, True
        self._thread = threading.Thread(target=self._run)

    def _run(self):
        while self._on:
            self._plant.wait(0.02)

    def __enter__(self):
        self._thread.start()

    def __exit__(self, *_):
        self._on = False
        self._thread.join()


def follows(server, follower, state):
    """Wait for a state; the clock goes on speaking, for a silent one is absent after 0.5 s."""
    eventually(lambda: server.beat() or follower.clock.state == state, what=state)


def test_without_a_clock_port_time_is_wall_time(plant):
    assert plant.clock.state == "absent"
    assert abs(plant.clock.time - time.time_ns()) < 1000 * MS
    assert plant.clock.now()[1] == 0
    began = time.monotonic()
    assert plant.clock.wait_until(time.time_ns() + 20 * MS, timeout=5.0)
    assert time.monotonic() - began >= 0.019


def test_a_clock_runs_pauses_steps_and_runs_again(served):
    server, follower = served
    assert (follower.clock.state, follower.clock.now()) == ("absent", (0, 1))
    server.update(5 * MS)
    follows(server, follower, "running")
    assert follower.clock.time == 5 * MS
    server.update(6 * MS, "paused")
    follows(server, follower, "paused")
    server.update(7 * MS, "paused")
    eventually(lambda: follower.clock.time == 7 * MS)
    follows(server, follower, "paused")
    server.update(8 * MS)
    follows(server, follower, "running")


def test_a_paused_clock_goes_on_speaking_and_a_silent_one_is_absent(served, plant):
    server, follower = served
    server.update(5 * MS, "paused")
    with Beating(plant):
        eventually(lambda: follower.clock.state == "paused")
        time.sleep(1.5 * SILENCE)
        eventually(lambda: follower.clock.state == "paused")
    eventually(lambda: follower.clock.state == "absent")
    assert follower.clock.time == 5 * MS


def test_waiting_for_simulated_time_ends_by_reaching_it_by_reset_or_by_wall_time(served):
    server, follower = served
    server.update(100 * MS)
    eventually(lambda: follower.clock.time == 100 * MS)
    threading.Timer(0.05, server.update, (200 * MS,)).start()
    assert follower.clock.wait_until(150 * MS, timeout=10.0)
    began = time.monotonic()
    assert not follower.clock.wait_until(500 * MS, timeout=0.1)
    assert 0.1 <= time.monotonic() - began < 5.0
    threading.Timer(0.05, server.update, (1 * MS,)).start()
    began = time.monotonic()
    assert not follower.clock.wait_until(10**12, timeout=30.0)
    assert time.monotonic() - began < 20.0
    assert follower.clock.resets == 1


def test_all_who_wait_wake_when_the_clock_is_reset(served, hub):
    server, _ = served
    server.update(100 * MS)
    results = []

    def follow(k):
        with Node(f"sleeper{k}", connect=hub, clock_port="/plant/clock:o", signals=False) as node:
            eventually(lambda: node.clock.time == 100 * MS or server.update(100 * MS))
            ready.release()
            results.append((node.clock.wait_until(10**12, timeout=30.0), node.clock.resets))

    ready = threading.Semaphore(0)
    threads = [threading.Thread(target=follow, args=(k,)) for k in range(3)]
    for thread in threads:
        thread.start()
    with Beating(server._output and served[1]):
        for _ in threads:
            while not ready.acquire(timeout=0.02):
                server.beat()
        began = time.monotonic()
        server.update(0)
        for thread in threads:
            thread.join()
    assert results == [(False, 1)] * 3
    assert time.monotonic() - began < 20.0


@pytest.mark.parametrize("end", ["reset", "shutdown", "arrival"])
def test_all_threads_that_sleep_wake_together(served, end):
    """In YARP one of three wakes when the time jumps back."""
    server, follower = served
    server.update(100 * MS)
    eventually(lambda: follower.clock.time == 100 * MS)
    results = []
    sleep = lambda: results.append(follower.clock.wait_until(150 * MS, timeout=60.0))  # noqa: E731
    threads = [threading.Thread(target=sleep) for _ in range(8)]
    for thread in threads:
        thread.start()
    act = {
        "reset": lambda: server.update(0),
        "shutdown": follower.stop,
        "arrival": lambda: server.update(150 * MS),
    }[end]
    threading.Timer(0.05, act).start()
    began = time.monotonic()
    sleep()  # in the node's own thread too
    for thread in threads:
        thread.join()
    assert results == [end == "arrival"] * 9
    assert time.monotonic() - began < 20.0


def test_waiting_for_wall_time_ends_when_the_process_is_asked_to_end(monkeypatch):
    clock = SessionClock(running=lambda: False)
    began = time.monotonic()
    assert not clock.wait_until(time.time_ns() + 60_000 * MS, timeout=60.0)
    assert time.monotonic() - began < 20.0


def test_a_loop_of_simulated_time_follows_steps_and_a_reset(served):
    server, follower = served
    server.update(0)
    follows(server, follower, "running")
    loop = Periodic.of(follower, 0.01)

    def step():
        for stamp in (*range(0, 101, 5), *range(0, 51, 5)):  # 100 ms, then 50 ms from 0 on
            server.update(stamp * MS, "paused")
            eventually(lambda stamp=stamp: follower.clock.time == stamp * MS)
            time.sleep(0.002)
        follower.stop()

    stepping = threading.Thread(target=step)
    stepping.start()
    while loop.next():
        pass
    stepping.join()
    assert 13 <= loop.statistics.cycles <= 15


def test_a_pause_is_not_staleness(served, plant):
    server, follower = served
    inp = follower.input("/follower/x:i", Number, rate=100.0)
    direct = plant.output("/follower/x:i", Number)
    eventually(lambda: direct.matched)

    def arrive():
        direct.write(Number(value=1.0))
        eventually(lambda: inp.newest(), what="the number")

    server.update(1 * MS)
    follows(server, follower, "running")
    arrive()
    server.update(1 * MS, "paused")
    follows(server, follower, "paused")
    arrive()
    with Beating(plant):
        time.sleep(1.5 * SILENCE)
        eventually(lambda: follower.clock.poll() or inp.fresh, what="fresh during the pause")
    server.update(2 * MS)
    follows(server, follower, "running")
    eventually(lambda: not inp.fresh, what="stale after the pause")
    assert inp.reason.startswith("nobody writes /follower/x:i") or "no data on" in inp.reason


@pytest.fixture
def lockstep(plant, hub):
    """A plant in lockstep with two services, which are ready."""
    lockstep = Lockstep(plant, ["one", "two"])
    plant.ready()
    services = [Node(name, connect=hub, lockstep=True, signals=False) for name in ("one", "two")]
    for service in services:
        service.ready()
    lockstep.join()
    for service in services:
        eventually(lambda s=service: s.lockstep._output is not None and s.lockstep._output.matched)
    yield lockstep, services
    for service in services:
        service.close()


def test_the_plant_waits_for_all_acknowledgements(lockstep):
    steps, services = lockstep
    for tick in range(1, 20):
        for service in services:
            service.acknowledge(tick * MS)
        steps.wait(tick * MS)
    for service in services:
        service.acknowledge(0)
    steps.wait(0)  # after a reset


def test_the_missing_participant_is_named(lockstep):
    steps, (one, _) = lockstep
    one.acknowledge(5)
    with pytest.raises(LockstepTimeout, match=r"^two did not acknowledge 5 ns within 0.2 s"):
        steps.wait(5, timeout=0.2)


def test_a_participant_that_never_came_is_named(plant):
    steps = Lockstep(plant, ["absent"])
    with pytest.raises(LockstepTimeout, match="absent did not come to the lockstep within 0.1 s"):
        steps.join(timeout=0.1)


def test_acknowledging_without_lockstep_does_nothing(plant):
    assert not plant.lockstep.enabled
    plant.acknowledge(5)
