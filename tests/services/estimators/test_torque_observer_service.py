"""The torque observer as a process."""

from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from bus import Node, RpcError
from robot_model import load_robot, ports
from robot_model.messages import ContactPoints
from robot_sim import Plant
from tests.services.estimators.feed import Feed, says

ROBOT = load_robot("icub")


@pytest.fixture
def feed(node: Node, start) -> Feed:
    start("services.torque_observer")
    return Feed(node, Plant(ROBOT), "torque_observer")


def ready(feed, *keys):
    inputs = [feed.listen(key) for key in keys]
    feed.node.ready()
    return inputs


def test_torques_and_wrenches_equal_the_plants_truth_of_their_stamp(feed):
    torques, wrenches = ready(feed, "torques", "wrenches")
    truths = {}

    def remembered(data):
        truths[feed.plant.time] = feed.plant.truth()
        return True

    said = feed.until(lambda: remembered(None) and says(torques, True))
    truth = truths[said.envelope.stamp]
    np.testing.assert_allclose(said.data.torque, truth.link_torque, atol=1e-5)
    assert said.data.valid.all() and (said.data.std > 0.0).all()
    said = feed.until(lambda: remembered(None) and says(wrenches, True))
    truth = truths[said.envelope.stamp]
    row = said.data.frame.index("l_sole")
    assert said.data.kind[row] == "support"
    np.testing.assert_allclose(said.data.wrench[row], truth.support_wrench[0], atol=1e-4)


def test_one_lost_sensor_costs_two_subtrees_and_says_so_by_flags(feed):
    (wrenches,) = ready(feed, "wrenches")
    lost = np.ones(len(ROBOT.ft_sensors), dtype=bool)
    lost[ROBOT.ft_sensors.index("l_arm_ft")] = False
    feed.changes = {"ft_valid": lost}
    said = feed.until(lambda: says(wrenches, True, lambda d: not d.subtree_valid.all())).data
    names = {ROBOT.subtrees[i].name for i in np.flatnonzero(~said.subtree_valid)}
    assert names == {"root", "l_arm"}
    assert not said.wrench[~said.valid].any()
    assert said.subtree_covariance.any(axis=(1, 2)).tolist() == said.subtree_valid.tolist()


def test_a_saturated_sensor_is_named_with_its_limit_by_all_that_depends_on_it(feed):
    torques, wrenches, predictions = ready(feed, "torques", "wrenches", "ft_prediction")
    sensor = ROBOT.ft_sensors.index("l_arm_ft")
    feed.changes = {
        "ft_valid": np.arange(6) != sensor,
        "faults": ["l_arm_ft: saturated (mz reached 25 N m)"],
    }
    text = "l_arm_ft is saturated (mz reached 25 N m)"
    said = feed.until(lambda: says(wrenches, True, lambda d: d.subtree_reasons)).data
    why = dict(zip([s.name for s in ROBOT.subtrees], said.subtree_reasons, strict=True))
    assert {name for name, reason in why.items() if reason == text} == {"root", "l_arm"}
    assert set(why.values()) == {text, ""}
    said = feed.until(lambda: says(torques, True, lambda d: d.reasons)).data
    assert [reason == text for reason in said.reasons] == (~said.valid).tolist()
    said = feed.until(lambda: says(predictions, True, lambda d: d.reasons)).data
    assert said.reasons[sensor] == text
    feed.changes = {}
    assert feed.until(lambda: says(torques, True, lambda d: d.valid.all())).data.reasons == []


def test_silence_turns_everything_invalid_with_a_reason_until_data_return(feed):
    ports_read = ready(feed, "torques", "wrenches", "ft_prediction")
    for port in ports_read:
        feed.until(lambda port=port: says(port, True))
    for port in ports_read:
        while (silent := says(port, False)) is None:
            feed.node.wait(0.1)
        assert "no data" in silent.envelope.reason and silent.envelope.stamp > 0
    for port in ports_read:
        feed.until(lambda port=port: says(port, True))


def test_contact_points_move_the_contact_at_run_time(feed):
    (wrenches,) = ready(feed, "wrenches")
    writer = feed.writer(ports.name("contact_points", ROBOT), ContactPoints)
    points = ContactPoints(link=["l_forearm"], point=np.array([[0.0, 0.01, 0.05]]))
    arm = ROBOT.subtree_of("l_forearm")

    def touched():
        writer.write(points)
        return says(wrenches, True, lambda d: d.kind[arm] == "touch")

    said = feed.until(touched).data
    assert said.frame[arm] == "l_forearm" and said.subtree[arm] == "l_arm"
    np.testing.assert_allclose(said.point[arm], [0.0, 0.01, 0.05])


@pytest.fixture
def followed(node, start):
    """An observer that reads where the contact detector finds touches."""
    start("services.torque_observer", "--set", "follow_touches=true")
    return Feed(node, Plant(ROBOT), "torque_observer")


NOTHING = ContactPoints(link=[], point=np.zeros((0, 3)))
FOREARM = ContactPoints(link=["l_forearm"], point=np.zeros((1, 3)), unknown=["force"])
ARM = ROBOT.subtree_of("l_forearm")


def test_a_touch_ends_with_the_detector_that_told_it(followed, hub):
    (wrenches,) = ready(followed, "wrenches")
    with Node("contact_detector", connect=hub, signals=False) as detector:
        places = detector.output(ports.name("touch_points", ROBOT), ContactPoints)
        detector.ready()

        def touched():
            places.write(FOREARM)
            return says(wrenches, True, lambda d: d.kind[ARM] == "touch")

        followed.until(touched)
    followed.until(lambda: says(wrenches, True, lambda d: d.kind[ARM] == "default"))


def test_a_detector_that_repeats_itself_leaves_alone_what_is_written_by_hand(followed, hub):
    (wrenches,) = ready(followed, "wrenches")
    hand = followed.writer(ports.name("contact_points", ROBOT), ContactPoints)
    with Node("contact_detector", connect=hub, signals=False) as detector:
        places = detector.output(ports.name("touch_points", ROBOT), ContactPoints)
        detector.ready()

        def said(by_detector, by_hand, kind):
            places.write(by_detector)
            if by_hand is not None:
                hand.write(by_hand)
            return says(wrenches, True, lambda d: d.kind[ARM] == kind)

        followed.until(lambda: said(FOREARM, None, "touch"))
        followed.until(lambda: said(NOTHING, None, "default"))
        followed.until(lambda: said(NOTHING, FOREARM, "touch"))
        kinds = set()
        for _ in range(50):
            places.write(NOTHING)
            followed.step()
            followed.node.wait(0.002)
            while (received := wrenches.read()) is not None:
                kinds.add(received.data.kind[ARM])
        assert kinds == {"touch"}


def test_contacts_on_one_subtree_share_its_wrench_and_what_is_undecided_is_told(feed):
    (wrenches,) = ready(feed, "wrenches")
    writer = feed.writer(ports.name("contact_points", ROBOT), ContactPoints)
    points = ContactPoints(
        link=["l_forearm", "l_hand", "r_hand"],
        point=np.array([[0.0, 0.01, 0.05], [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]]),
        unknown=["wrench", "direction", "none"],
        vector=np.vstack([np.zeros(6), [0.0, 0.0, 2.0, 0.0, 0.0, 0.0], np.zeros(6)]),
    )
    right, count = ROBOT.subtree_of("r_hand"), len(ROBOT.subtrees)

    def touched():
        writer.write(points)
        return says(wrenches, True, lambda d: "l_hand" in d.frame)

    said = feed.until(touched).data
    row = said.frame.index("l_hand")
    assert said.frame[row - 1] == "l_forearm" and "r_hand" not in said.frame
    assert said.decided == [i not in (row - 1, row) for i in range(count)]
    assert said.undecided.shape == (1, count, 6) and said.undecided[0, row].any()
    told = feed.node.call(ports.rpc("torque_observer"), "wrench", {"of": "contact:l_hand"})
    # of another sample: the sign of a pattern means nothing, its size follows the posture
    patterns = np.abs(told["undecided"]), np.abs(said.undecided[:, row])
    np.testing.assert_allclose(*patterns, atol=0.05)
    assert not told["decided"]
    assert said.rank[right] == 0.0 and said.rank[said.subtree.index("l_arm")] == 6.0
    np.testing.assert_allclose(said.unexplained[right], said.subtree_wrench[right])


def test_silence_is_told_of_every_contact_when_one_was_added(feed):
    (wrenches,) = ready(feed, "wrenches")
    writer = feed.writer(ports.name("contact_points", ROBOT), ContactPoints)
    points = ContactPoints(link=["l_forearm", "l_hand"], point=np.zeros((2, 3)))

    def added():
        writer.write(points)
        return says(wrenches, True, lambda d: len(d.frame) == len(ROBOT.subtrees) + 1)

    frames = feed.until(added).data.frame
    while (silent := says(wrenches, False)) is None:
        feed.node.wait(0.1)
    assert silent.data.frame == frames and not silent.data.wrench.any()


def test_any_wrench_is_told_in_any_frame(feed):
    (wrenches,) = ready(feed, "wrenches")
    feed.until(lambda: says(wrenches, True))

    def ask(**arguments):
        return feed.node.call(ports.rpc("torque_observer"), "wrench", arguments)

    own = ask(of="link:l_hand")
    assert own["frame"] == own["axes"] == "l_hand" and own["valid"] and own["reason"] == ""
    moved = ask(of="link:l_hand", frame="l_hand", axes="root_link", point=[0.0, 0.0, 0.1])
    assert np.linalg.norm(moved["force"]) == pytest.approx(np.linalg.norm(own["force"]), rel=0.05)
    assert moved["axes"] == "root_link" and moved["stamp"] >= own["stamp"]
    assert np.linalg.eigvalsh(moved["covariance"]).min() > 0.0
    assert moved["decided"] and moved["undecided"] == []
    with pytest.raises(RpcError, match="did you mean 'l_hand'"):
        ask(of="link:l_hnad")


def test_contact_points_of_different_lengths_change_nothing_and_are_told(feed):
    (wrenches,) = ready(feed, "wrenches")
    writer = feed.writer(ports.name("contact_points", ROBOT), ContactPoints)
    feed.until(lambda: says(wrenches, True))
    odd = ContactPoints(link=["l_hand"], point=np.zeros((1, 3)), unknown=["force", "force"])

    def told():
        writer.write(odd)
        return feed.node.call(ports.rpc("torque_observer"), "status")["contact_error"]

    assert "1 links, 1 points, 2 kinds of unknowns" in feed.until(told)


def test_a_changed_support_changes_the_kinds_and_a_wrong_one_is_refused(feed):
    (wrenches,) = ready(feed, "wrenches")
    rpc = ports.rpc("torque_observer")
    feed.node.call(rpc, "param", {"action": "set", "name": "support", "value": "pole"})
    said = feed.until(lambda: says(wrenches, True, lambda d: "root_link" in d.frame)).data
    assert said.kind[0] == "support" and said.kind.count("support") == 1
    with pytest.raises(RpcError, match="support"):
        feed.node.call(rpc, "param", {"action": "set", "name": "support", "value": "wall"})


def set_source(feed, name):
    value = {"action": "set", "name": "kinematic_source", "value": name}
    return feed.node.call(ports.rpc("torque_observer"), "param", value)


def test_a_kinematic_source_chosen_at_run_time_tells_the_same_torques(node, start):
    start("services.torque_observer", "--set", "robot=icub_inertial", "--set", "support=pole")
    robot = load_robot("icub_inertial")
    feed = Feed(node, Plant(robot, base="fixed"), "torque_observer")
    torques, truths = feed.listen("torques"), {}
    feed.node.ready()

    def agrees(after):
        truths[feed.plant.time] = feed.plant.truth().link_torque
        if (said := says(torques, True)) is not None and said.envelope.stamp > after:
            return np.abs(said.data.torque - truths[said.envelope.stamp]).max() < 1e-5
        return False

    def lost(name):
        said = says(torques, False)
        return said is not None and said.envelope.reason == f"no data from {name}"

    flags = np.ones(len(robot.imus), dtype=bool)
    flags[0] = False
    feed.changes = {"imu_valid": flags}
    for source in ("fusion", "fixed:root_link"):
        set_source(feed, source)
        assert feed.node.call(ports.rpc("torque_observer"), "status")["kinematic_source"] == source
        assert feed.until(lambda after=feed.plant.time: agrees(after))
    set_source(feed, "first")
    assert feed.until(lambda: lost("head_imu_0"))
    set_source(feed, "fusion")
    feed.changes = {"imu_valid": np.zeros_like(flags)}
    assert feed.until(lambda: lost("fusion"))
    with pytest.raises(RpcError, match="no inertial sensor 'hand'"):
        set_source(feed, "hand")


def test_tare_refuses_a_moving_robot_and_answers_a_resting_one(feed, hub):
    (torques,) = ready(feed, "torques")
    feed.until(lambda: says(torques, True))

    def call(verb, arguments):
        with Node("asker", connect=hub, signals=False) as asker:
            asker.ready()
            return asker.call(ports.rpc("torque_observer"), verb, arguments, timeout=20.0)

    def tare(**more):
        return call("tare", more or {"seconds": 0.1})

    def ask(pool, verb, arguments):
        answer = pool.submit(call, verb, arguments)
        feed.until(answer.done)
        return answer.result()

    with ThreadPoolExecutor(1) as pool:
        feed.changes = {"dq": np.full(ROBOT.n, 0.5)}
        refused = pool.submit(tare)
        feed.until(refused.done)
        with pytest.raises(RpcError, match="the robot moves: .* at 0.500 rad/s"):
            refused.result()
        resting = {"q": np.array(ROBOT.home), "dq": np.zeros(ROBOT.n)}
        feed.changes = {**resting, "imu_gyro": np.zeros((1, 3))}
        answered = pool.submit(tare)
        feed.until(answered.done)
        reply = answered.result()
        assert reply["tared"] == ["l_arm_ft", "r_arm_ft"]
        assert "cannot be observed" in reply["message"]
        assert np.array(reply["offset"]).shape == (6, 6)
        check_store(reply, lambda verb, **more: ask(pool, verb, more))
        refused = pool.submit(tare, samples=30, stance="l_sole")
        feed.until(refused.done)
        with pytest.raises(RpcError, match="more than an offset, limit 40 N"):
            refused.result()


def check_store(reply, ask):
    """The tare is listed with its spread, can be reverted and chosen again."""
    status = ask("status")
    assert status["tare"]["date"] == reply["date"] and status["tare"]["stance"] == "floor"
    assert status["tare"]["load"] is False and len(status["tare"]["spread"]) == 6
    assert ask("tares")["tares"][-1]["date"] == reply["date"]
    assert ask("revert_tare")["in_use"] == ""
    assert not any(map(any, ask("status")["offset"].values()))
    assert ask("use_tare", date=reply["date"])["in_use"] == reply["date"]
    with pytest.raises(RpcError, match="expected the date of one tare, got '1999'"):
        ask("use_tare", date="1999")
