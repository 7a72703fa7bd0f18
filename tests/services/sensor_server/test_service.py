"""The sensor server on a driver in memory, stepped by the test, on a real bus."""

import time
from concurrent.futures import ThreadPoolExecutor

import numpy as np
import pytest

from bus import RpcError
from bus.testing import eventually
from robot_model import ports
from robot_model.ft_convention import from_wrenchbus
from robot_model.messages import (
    GravityTorques,
    Inertial,
    JointCommand,
    JointTorques,
    PartForceTorque,
    PartState,
    SensorFrame,
)

PATIENCE = 60.0  # [s]
HELD = 8  # messages, fewer than a link holds


@pytest.fixture
def types(robot):
    return {"model": robot.model_hash, "dimensions": robot.dimensions}


@pytest.fixture
def frames(bench, client, types):
    """An input on the sensor frames, matched."""
    port = client.input(
        "/icub/client/sensors:i", SensorFrame, source="/icub/sensors:o", depth=500, **types
    )
    bench.node.ready()
    client.ready()
    until_received(bench, port)
    return port


def until_received(bench, port):
    """Step the server until a message arrives on a port that has just been opened."""

    def received():
        bench.step()
        return port.read()

    return eventually(received, PATIENCE)


def drained(bench, port, frames: int = 1, **changes):
    """Step the server, and return everything that arrives, up to the server's last stamp."""
    received = []

    def complete():
        while (sample := port.read()) is not None:
            received.append(sample)
        return received and received[-1].envelope.stamp == bench.stamp

    for begin in range(0, frames, HELD):
        bench.run(min(HELD, frames - begin), **changes)
        eventually(complete, PATIENCE)
    return received


def writer(bench, client, key, message, types):
    """A direct writer onto one of the server's inputs, matched."""
    output = client.output(ports.name(key, bench.robot), message, **types)
    eventually(lambda: output.matched, PATIENCE)
    return output


def status_until(bench, predicate):
    """Step the server until its status satisfies a predicate."""

    def satisfied():
        bench.step()
        return predicate(bench.server.status())

    eventually(satisfied, PATIENCE)
    return bench.server.status()


def asked(bench, client, verb, **arguments):
    """Call a verb while the server goes on."""
    with ThreadPoolExecutor(1) as pool:
        future = pool.submit(client.call, "/sensor_server/rpc:i", verb, arguments)
        while not future.done():
            bench.step()
        return future.result()


def test_every_frame_is_published_once_with_its_times(bench, frames):
    first = bench.stamp
    received = drained(bench, frames, 50)
    stamps = [r.envelope.stamp for r in received if r.envelope.stamp > first]
    assert stamps == [first + (i + 1) * 1_000_000 for i in range(50)]
    last = received[-1].envelope
    assert last.valid and last.clock == 1 and 0 <= last.sent - last.acquired < 1_000_000_000


def test_frames_of_positions_only_are_differentiated_with_the_stated_delay(bench, frames):
    positions = {"dq": None, "ddq": None, "imu_dgyro": None}
    first = drained(bench, frames, 1, **positions)[-1]
    assert not first.envelope.valid and "window holds" in first.envelope.reason
    last = drained(bench, frames, 60, **positions)[-1]
    assert last.envelope.valid and last.data.delay == 0.024 and last.data.joint_valid.all()


def test_a_lost_sensor_costs_one_channel_after_two_frames(bench, frames, robot):
    positions = {"dq": None, "ddq": None, "imu_dgyro": None}
    bench.run(60, **positions)
    lost = np.arange(6) != 2
    last = drained(bench, frames, 2, ft_valid=lost, **positions)[-1]
    np.testing.assert_array_equal(last.data.ft_valid, lost)
    assert last.envelope.valid and last.data.joint_valid.all() and not last.data.ft[2].any()


def test_a_saturated_sensor_is_invalid_and_the_frame_names_the_limit(bench, frames, robot):
    ft = np.ones((6, 6))
    ft[2, 4] = -36.0
    last = drained(bench, frames, ft=ft)[-1]
    assert last.envelope.valid and last.data.ft_valid.tolist() == [i != 2 for i in range(6)]
    assert last.data.faults == ["l_leg_ft: saturated (my reached 35 N m)"]
    assert drained(bench, frames)[-1].data.faults == []


def test_values_that_are_not_finite_cost_their_channel_only(bench, frames, robot):
    q = np.array(robot.home)
    q[5] = np.nan
    last = drained(bench, frames, q=q)[-1]
    assert last.envelope.valid
    np.testing.assert_array_equal(last.data.joint_valid, np.arange(robot.n) != 5)


def test_silence_is_said_fifty_times_a_second_and_ends_by_itself(bench, frames):
    bench.step()
    start = time.monotonic()
    invalid = []

    def said() -> bool:
        bench.server.spin()
        while (sample := frames.read()) is not None:
            if not sample.envelope.valid:
                invalid.append(sample)
        return len(invalid) >= 10

    eventually(said, PATIENCE)
    assert len(invalid) <= 1 + 52.0 * (time.monotonic() - start)
    assert "silent for" in invalid[-1].envelope.reason
    assert invalid[-1].envelope.stamp == bench.stamp
    assert not invalid[-1].data.joint_valid.any() and not invalid[-1].data.q.any()
    assert drained(bench, frames)[-1].envelope.valid


def test_a_view_is_written_only_while_somebody_listens(bench, frames, client, robot):
    views = bench.server.frames.views
    state, ft, inertial = (
        client.input(f"/icub/client/{what}:i", message, source=source)
        for what, message, source in (
            ("state", PartState, "/icub/left_arm/state:o"),
            ("ft", PartForceTorque, "/icub/left_arm/ft:o"),
            ("inertial", Inertial, "/icub/inertial:o"),
        )
    )
    received = until_received(bench, state)
    view = received.data
    assert received.envelope.model == robot.model_hash and view.motor_torque_valid
    assert view.joints == [robot.joints[i] for i in robot.parts["left_arm"]]
    np.testing.assert_allclose(view.q, robot.home[robot.parts["left_arm"]])
    assert until_received(bench, ft).data.sensors == ["l_arm_ft"]
    assert until_received(bench, inertial).data.sensors == list(robot.imus)
    written = {port.name for port in views.outputs if port.statistics.written}
    assert written == {"/icub/left_arm/state:o", "/icub/left_arm/ft:o", "/icub/inertial:o"}


def test_raw_readings_in_the_urdf_convention_are_converted(urdf_bench, robot):
    readings = 0.5 * np.arange(36.0).reshape(6, 6)  # within the sensors' ranges
    urdf_bench.node.ready()
    urdf_bench.step(ft=from_wrenchbus(robot, readings))
    np.testing.assert_allclose(urdf_bench.server.frames.frame.ft, readings, atol=1e-9)


def test_commands_of_one_writer_reach_the_boards_and_another_ones_are_refused(
    bench, frames, client, types, robot
):
    mine = writer(bench, client, "command", JointCommand, types)
    mine.write(JointCommand(mode="position", value=np.full(robot.n, 100.0)))
    status_until(bench, lambda status: status["writer"])
    np.testing.assert_array_equal(bench.driver.commands[-1].value, robot.position_upper)
    other = writer(bench, client, "command", JointCommand, types)
    other.write(JointCommand(mode="position", value=robot.home))
    status = status_until(bench, lambda status: status["commands_refused"] == 1)
    assert "lease" in status["last_refusal"] and status["writer"] == mine.source.hex()
    np.testing.assert_array_equal(bench.driver.commands[-1].value, robot.position_upper)
    status_until(bench, lambda status: not status["writer"])
    other.write(JointCommand(mode="position", value=robot.home))
    status_until(bench, lambda status: status["writer"] == other.source.hex())


def test_a_torque_command_that_is_not_renewed_ends_in_a_safe_hold(
    bench, frames, client, types, robot
):
    out = writer(bench, client, "command", JointCommand, types)
    out.write(JointCommand(mode="torque", value=np.zeros(robot.n)))
    eventually(lambda: bench.step() or bench.driver.commands[-1].mode == "torque", PATIENCE)
    status = status_until(bench, lambda status: status["holding"])
    assert "no torque command" in status["reason"] and bench.driver.commands[-1].mode == "position"


def test_a_torque_command_ends_in_a_safe_hold_also_when_the_frames_stay_away(
    bench, frames, client, types, robot
):
    out = writer(bench, client, "command", JointCommand, types)
    bench.step()

    def taken():
        out.write(JointCommand(mode="torque", value=np.zeros(robot.n)))
        bench.step()
        return bench.server.status()["mode"] == "torque"

    eventually(taken, PATIENCE)

    def held():
        bench.server.spin()
        return bench.server.status()["holding"]

    eventually(held, PATIENCE)


def test_the_feedforward_follows_valid_messages_and_fades_without_them(
    bench, frames, client, types, robot
):
    gravity = writer(bench, client, "feedforward", GravityTorques, types)

    def fed(valid: bool):
        gravity.write(GravityTorques(torque=np.ones(robot.n)), valid=valid, reason="no base")
        bench.step()
        return bench.driver.commands[-1].feedforward

    bench.step()
    eventually(lambda: (fed(True) == 1.0).all(), PATIENCE)
    eventually(lambda: (fed(False) == 0.0).all(), PATIENCE)


def test_a_pause_is_not_silence_of_the_feedforward(bench, frames, client, types, robot):
    gravity = writer(bench, client, "feedforward", GravityTorques, types)

    def fed():
        gravity.write(GravityTorques(torque=np.ones(robot.n)))
        bench.step()
        return bench.server.status()["feedforward"] == 1.0

    eventually(fed, PATIENCE)
    bench.driver.paused = True
    deadline = time.monotonic() + 0.3
    while time.monotonic() < deadline:
        bench.server.spin()
    assert bench.server.status()["feedforward"] == 1.0


def test_stop_refuses_commands_until_release(bench, frames, client, types, robot):
    out = writer(bench, client, "command", JointCommand, types)
    reply = asked(bench, client, "stop")
    assert reply["stopped"] and reply["holding"]
    out.write(JointCommand(mode="position", value=robot.home))
    status = status_until(bench, lambda status: status["commands_refused"])
    assert "release first" in status["last_refusal"]
    assert not asked(bench, client, "release")["stopped"]
    out.write(JointCommand(mode="position", value=robot.home))
    status_until(bench, lambda status: status["writer"])


def test_the_age_of_virtual_torques_is_measured(bench, frames, client, types, robot):
    out = writer(bench, client, "virtual_torque", JointTorques, types)
    n = robot.n
    torques = JointTorques(torque=np.zeros(n), std=np.zeros(n), valid=np.arange(n) > 3)
    for _ in range(HELD):
        out.write(torques, acquired=time.time_ns() - 50_000_000)
    out.write(torques, valid=False, reason="stale", acquired=0)
    status_until(bench, lambda status: status["virtual_torque_age"]["count"] == HELD)
    status = asked(bench, client, "status")
    age = status["virtual_torque_age"]
    assert 0.05 <= age["p50"] <= age["p99"] <= age["max"] < 20.0


def test_live_settings_change_filter_and_limits(bench, frames, client, robot):
    assert asked(bench, client, "param", action="set", name="filter.delay", value=0.01) == 0.01
    bench.run(60, dq=None, ddq=None, imu_dgyro=None)
    assert drained(bench, frames, dq=None, ddq=None, imu_dgyro=None)[-1].data.delay == 0.01
    with pytest.raises(RpcError, match="filter.delay"):
        asked(bench, client, "param", action="set", name="filter.delay", value=-1)
    assert asked(bench, client, "param", action="get", name="filter.delay") == 0.01


@pytest.mark.parametrize(("name", "value"), [("driver", "replay"), ("rate", 500.0)])
def test_what_cannot_change_while_it_runs_is_refused(bench, name, value):
    with pytest.raises(ValueError, match=f"{name} cannot be changed while the service runs"):
        bench.node.parameters.set(name, value)


@pytest.mark.parametrize("method", ["adaptive", "kalman"])
def test_another_method_is_chosen_live_and_states_its_delay(bench, frames, client, method):
    positions = {"dq": None, "ddq": None, "imu_dgyro": None}
    assert asked(bench, client, "param", action="set", name="filter.method", value=method) == method
    asked(bench, client, "param", action="set", name="filter.delay", value=0.012)
    bench.run(60, **positions)
    last = drained(bench, frames, **positions)[-1]
    assert last.data.delay == 0.012 and last.data.joint_valid.all()
    np.testing.assert_allclose(last.data.q, bench.robot.home, atol=1e-9)
    np.testing.assert_allclose(last.data.ddq, 0.0, atol=1e-5)


def test_a_lag_beyond_the_memory_is_refused_and_the_filter_stays(bench, frames, client):
    asked(bench, client, "param", action="set", name="filter.method", value="kalman")
    with pytest.raises(RpcError, match="memory must reach at least 3 samples beyond the delay"):
        asked(bench, client, "param", action="set", name="filter.delay", value=0.05)
    assert asked(bench, client, "param", action="get", name="filter.delay") == 0.024


def test_a_lag_that_would_not_be_the_one_delay_of_all_channels_is_refused(bench, frames, client):
    asked(bench, client, "param", action="set", name="filter.method", value="kalman")
    asked(bench, client, "param", action="set", name="filter.kalman.noise", value=4.4e-4)
    with pytest.raises(RpcError, match=r"accelerations would be \+10.7 ms off the 12 ms"):
        asked(bench, client, "param", action="set", name="filter.delay", value=0.012)
