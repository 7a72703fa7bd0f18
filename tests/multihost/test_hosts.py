"""One robot on three hosts, and cables that are pulled."""

import json
import time
from collections.abc import Iterable, Iterator
from itertools import pairwise

import pytest

from bus.testing import eventually
from tests.multihost.lab import Lab, Witness, is_good

pytestmark = pytest.mark.system

DETECTED = 2.0 + 1.0  # s: the lease, and what a loaded machine adds
AGAIN = 10.0  # s; figures of a machine at rest are in docs/deployment.md


@pytest.fixture
def witnesses(lab: Lab) -> Iterator[tuple[Witness, Witness]]:
    """Those on the desk and beside the estimators; data flow before and after the test."""
    both = lab.desk, lab.brain
    for witness in both:
        witness.await_good()
    yield both
    for witness in both:
        witness.await_good()


def assert_nothing_old_was_fresh(witness: Witness, back: float) -> None:
    """No stamp came twice or late, and what was judged good had been measured just then."""
    everything = witness.messages()
    for source in {message["source"] for message in everything}:
        stamps = [m["stamp"] for m in everything if m["source"] == source and m["valid"]]
        assert all(a < b for a, b in pairwise(stamps))
    assert all(m["age"] < 2.0 for m in witness.messages(back) if is_good(m))


def test_all_services_of_all_hosts_are_ready_and_say_that_they_are_insecure(lab):
    rows = json.loads(lab.command("desk", "status", "--json"))
    assert {row["service"]: row["host"] for row in rows} == {
        **dict.fromkeys(("hub", "robot_sim", "sensor_server"), "robot"),
        **dict.fromkeys(("base_estimator", "torque_observer"), "brain"),
        **dict.fromkeys(("gravity_compensator", "contact_detector"), "brain"),
        "dashboard": "desk",
    }
    assert all(row["ready"] for row in rows)
    for host, count in (("robot", 4), ("brain", 5), ("desk", 2)):  # launchers and processes
        assert lab.launchers[host].output.count("insecure: everybody") == count


def test_the_command_line_of_a_third_host_needs_no_flags(lab):
    owners = {
        row["name"]: row["owner"] for row in json.loads(lab.command("desk", "list", "--json"))
    }
    assert owners["/icub/sensors:o"]["host"] == "robot"
    assert owners["/icub/torques:o"]["host"] == "brain"
    assert owners["/dashboard/rpc:i"]["host"] == "desk"
    [line] = lab.command("desk", "read", "/icub/torques:o", "-n", "1", "--json").splitlines()
    assert len(json.loads(line)["data"]["torque"]) == 32


def test_the_page_is_served_on_its_own_host_only(lab):
    lab.until("desk", "page:    http://127.0.0.1:")
    url = lab.launchers["desk"].output.partition("page:    ")[2].split()[0]
    assert "<html" in lab.hosts["desk"].run("tests.multihost.fetch", url)
    with pytest.raises(AssertionError, match="refused"):
        lab.hosts["brain"].run("tests.multihost.fetch", url.replace("127.0.0.1", "10.0.0.3"))


@pytest.mark.parametrize(
    ("host", "at_switch"), [("brain", True), ("robot", False)], ids=["estimators", "robot"]
)
def test_a_cable_that_is_out_for_5_s(lab, witnesses, host, at_switch):
    with lab.hosts[host].without_cable(at_switch) as cut:
        for witness in witnesses:
            noticed = eventually(lambda: witness.trouble(cut), DETECTED)  # noqa: B023
            assert noticed["reason"]
        sleep_until(cut + 5.0)
        assert not any(witness.good(cut + DETECTED) for witness in witnesses)
    back = time.monotonic()
    check_return(witnesses, back)


def test_two_hosts_that_lose_each_other_but_not_the_hub_meet_again(lab, witnesses):
    desk, _ = witnesses
    with lab.hosts["brain"].without(lab.hosts["desk"]) as cut:
        assert eventually(lambda: desk.trouble(cut), DETECTED)["reason"]
        sleep_until(cut + 3.0)  # beyond the lease: the link is given up
        assert desk.good(cut + 2.0) is None
    check_return([desk], time.monotonic())


def check_return(witnesses: Iterable[Witness], back: float) -> None:
    """Data come soon after an instant, and nothing old is taken for new."""
    for witness in witnesses:
        good = eventually(lambda: witness.good(back), AGAIN)  # noqa: B023
        print(f"good again on {witness.host} {good['at'] - back:.2f} s after the return")
    for witness in witnesses:
        assert_nothing_old_was_fresh(witness, back)


def sleep_until(instant: float) -> None:
    time.sleep(max(0.0, instant - time.monotonic()))


def test_down_ends_all_hosts(lab):
    lab.command("desk", "down")
    for launcher in lab.launchers.values():
        assert launcher.popen.wait(20.0) == 0
