"""Each service killed and suspended, while the rest goes on and recovers by itself."""

import time

import pytest

from tests.system.stack import MODULES, PATIENCE, STREAMS, Stack

pytestmark = [pytest.mark.system, pytest.mark.timeout(300)]
SERVICES = ("hub", *MODULES)
CALM = 1.5  # s
FEEDFORWARD, LONGEST = "gravity_compensator", "torque_observer"  # each with a test of its own
OWNED = {
    "robot_sim": (),
    "sensor_server": ("sensors",),
    "base_estimator": ("base",),
    "torque_observer": ("torques", "wrenches", "ft_prediction"),
    "gravity_compensator": ("gravity",),
    "contact_detector": ("residuals", "contacts"),
    "dashboard": (),
    "hub": (),
}
# streams of other services that cannot be right without a service
DEPENDENT = {
    "robot_sim": STREAMS,
    "sensor_server": ("base", "torques", "wrenches", "gravity", "residuals", "contacts"),
    "base_estimator": ("gravity",),
}


def lost(stack: Stack, service: str) -> bool:
    """Whether what a service writes is silent, and what depends on it says that it is invalid."""
    states = stack.states()
    silent = all(states[key] == "silent" for key in OWNED[service])
    dependent = DEPENDENT.get(service, ())
    return silent and all(states[key] not in ("valid", "silent") for key in dependent)


def others_go_on(stack: Stack, service: str) -> bool:
    states = stack.states()
    return all(states[key] != "silent" for key in STREAMS if key not in OWNED[service])


def await_loss(stack: Stack, service: str) -> None:
    stack.until(lambda: lost(stack, service), lambda: f"without {service}: {stack.states()}")
    stack.until(
        lambda: others_go_on(stack, service), lambda: f"without {service}: {stack.states()}"
    )


@pytest.mark.parametrize("service", [s for s in SERVICES if s != FEEDFORWARD])
def test_a_killed_service_is_missed_and_comes_back(stack: Stack, service: str):
    stack.processes[service].kill()
    await_loss(stack, service)
    stack.assert_running(service)
    stack.start(service)
    if service != "hub":
        stack.await_ready([service])
    stack.await_whole()


@pytest.mark.parametrize("service", [s for s in SERVICES if s != LONGEST])
def test_a_suspended_service_is_missed_and_goes_on(stack: Stack, service: str):
    stack.suspend(service)
    try:
        await_loss(stack, service)
        stack.until(lambda: not stack.status(service, 0.5), lambda: f"{service} answers")
    finally:
        stack.resume(service)
    stack.await_whole()
    stack.until(lambda: stack.status(service), lambda: f"{service} does not answer")


def test_a_service_suspended_for_longer_than_its_lease_comes_back(stack: Stack):
    name = "/icub/torques:o"
    stack.suspend(LONGEST)
    try:
        await_loss(stack, LONGEST)
        stack.until(lambda: stack.node.directory.leader(name) is None, lambda: f"{name} stands")
    finally:
        stack.resume(LONGEST)
    stack.until(lambda: stack.node.directory.leader(name), lambda: f"{name} does not stand")
    stack.await_whole()
    stack.until(lambda: stack.status(LONGEST), lambda: f"{LONGEST} does not answer")


def test_without_the_gravity_compensator_the_feedforward_fades_and_the_robot_stays_up(
    stack: Stack,
):
    def factor() -> float | None:
        return stack.status("sensor_server").get("feedforward")

    stack.until(lambda: factor() == 1.0, lambda: f"feed-forward {factor()}")
    stack.processes[FEEDFORWARD].kill()
    await_loss(stack, FEEDFORWARD)
    stack.until(lambda: factor() == 0.0, lambda: f"feed-forward {factor()}")
    assert not stack.simulate("status")["fallen"]
    stack.assert_running(FEEDFORWARD)
    stack.start(FEEDFORWARD)
    stack.await_ready([FEEDFORWARD])
    stack.until(lambda: factor() == 1.0, lambda: f"feed-forward {factor()}")
    assert not stack.simulate("status")["fallen"]


def test_second_owners_of_names_are_refused_and_told_who_has_them(stack: Stack):
    seconds = {service: stack.run(service) for service in SERVICES}  # at once: starting is slow
    try:
        for service, second in seconds.items():
            second.expected = None
            assert second.popen.wait(PATIENCE) == 1, service
            owner = str(stack.pids[service])
            wanted = [stack.endpoint.rpartition(":")[2]] if service == "hub" else [owner, service]
            lines = second.output.splitlines()  # Zenoh may say something after the refusal
            assert any(all(word in line for word in wanted) for line in lines), second.output
    finally:
        for second in seconds.values():
            second.clean_up()


def test_pause_is_not_silence(stack: Stack):
    last = time.monotonic()

    def feedforward() -> float:
        return stack.status("sensor_server").get("feedforward") or 0.0

    def is_paused_while_fed() -> bool:
        """Pause; go on when the machine was too slow just then for the feed-forward."""
        stack.simulate("pause")
        if feedforward() > 0.9:
            return True
        stack.simulate("resume")
        return False

    def is_calm() -> bool:
        """Whether nothing was invalid for a while; of silence, streams speak all the time."""
        nonlocal last
        if set(stack.states().values()) - {"valid", "silent"}:
            last = time.monotonic()
        return time.monotonic() - last > CALM

    try:
        stack.until(is_paused_while_fed, lambda: f"feed-forward {feedforward()}")
        stack.until(is_calm, lambda: str(stack.states()))
        assert feedforward() > 0.5  # fades in 0.5 s
    finally:
        stack.simulate("resume")
