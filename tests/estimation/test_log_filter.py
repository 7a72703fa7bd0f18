"""The sensor pipeline over a log gives the stream's numbers, without its delay."""

from dataclasses import replace

import numpy as np
import pytest

from estimation.differentiation import Kernel
from estimation.offline.log_filter import LogFilter
from estimation.offline.sensor_log import SensorLog
from estimation.sensor_pipeline import SensorPipeline
from robot_model import Robot
from robot_model.messages import RawFrame

SIZE, SIDE = 160, 24
FIELDS = ("q", "dq", "ddq", "motor_torque", "ft", "imu_gyro", "imu_acc", "imu_dgyro")
FLAGS = ("joint_valid", "ft_valid", "imu_valid")


@pytest.fixture
def log(robot) -> SensorLog:
    random = np.random.default_rng(3)
    n, k, m = (robot.dimensions[letter] for letter in "nkm")
    return SensorLog(
        stamp=5_000_000 + 1_000_000 * np.arange(SIZE),
        q=random.normal(size=(SIZE, n)).cumsum(axis=0) * 1e-3,
        motor_torque=random.normal(size=(SIZE, n)),
        ft=random.normal(size=(SIZE, k, 6)),
        imu_gyro=random.normal(size=(SIZE, m, 3)),
        imu_acc=random.normal(size=(SIZE, m, 3)),
        joint_valid=np.ones((SIZE, n), dtype=bool),
        ft_valid=np.ones((SIZE, k), dtype=bool),
        imu_valid=np.ones((SIZE, m), dtype=bool),
    )


def kept(log: SensorLog, rows: np.ndarray) -> SensorLog:
    """Return some samples of a log."""
    names = ("stamp", "q", "motor_torque", "ft", "imu_gyro", "imu_acc", *FLAGS)
    return replace(log, **{name: getattr(log, name)[rows] for name in names})


def streamed(log: SensorLog, robot: Robot) -> dict:
    """Return the pipeline's frames by the instants that they describe."""
    pipeline, found = SensorPipeline(robot), {}
    names = ("q", "motor_torque", "ft", "imu_gyro", "imu_acc", *FLAGS)
    for row, stamp in enumerate(log.stamp.tolist()):
        raw = RawFrame(**{name: getattr(log, name)[row] for name in names})
        frame = pipeline.step(raw, stamp)
        if not pipeline.reason:
            found[stamp - SIDE * 1_000_000] = frame
    return found


def assert_alike(log: SensorLog, robot: Robot, length: int) -> set[int]:
    """Compare the log's blocks with the stream; return the stamps that are in both."""
    frames, seen = streamed(log, robot), set()
    for block in LogFilter(log).blocks(length):
        for i, stamp in enumerate(block.stamp.tolist()):
            assert log.stamp[block.rows.start + i] == stamp
            if stamp not in frames:
                continue
            ours, theirs = block.frame(i), frames[stamp]
            seen.add(stamp)
            for name in FLAGS:
                assert (getattr(ours, name) == getattr(theirs, name)).all(), (stamp, name)
            for name in FIELDS:
                assert np.allclose(getattr(ours, name), getattr(theirs, name), atol=1e-9), name
    assert not (set(log.stamp.tolist()) & frames.keys()) - seen
    return seen


@pytest.mark.parametrize("length", [1, 7, 100, 1000])
def test_a_log_gives_what_the_stream_gives(log, robot, length):
    assert len(assert_alike(log, robot, length)) == SIZE - 2 * SIDE


def test_short_gaps_are_bridged_and_long_ones_empty_the_window(log, robot):
    rows = np.setdiff1d(np.arange(SIZE), [40, 41, 90, 91, 92, 93, 94, 95])
    gappy = kept(log, rows)
    seen = assert_alike(gappy, robot, 10)
    stamps = 5 + np.array(sorted(seen)) // 1_000_000 - 10
    assert 39 in stamps and 42 in stamps and 65 in stamps
    assert not ((stamps > 89 - SIDE) & (stamps < 96 + SIDE)).any()
    assert LogFilter(gappy).breaks.tolist() == [88]


def test_a_lost_channel_is_invalid_while_the_window_holds_it(log):
    log.ft_valid[60:64, 2] = False
    log.ft[60:64, 2] = 0.0
    blocks = list(LogFilter(log).blocks(SIZE))
    lost = np.flatnonzero(~blocks[0].ft_valid[:, 2]) + blocks[0].rows.start
    assert lost.tolist() == list(range(60 - SIDE, 64 + SIDE))
    assert not blocks[0].ft[~blocks[0].ft_valid[:, 2], 2].any() and not blocks[0].complete


def test_one_lost_sample_of_a_channel_is_bridged_by_a_straight_line(log):
    expected = replace(log, q=log.q.copy())
    expected.q[70] = 0.5 * (log.q[69] + log.q[71])
    log.joint_valid[70] = False
    log.q[70] = 0.0
    blocks = [next(LogFilter(each).blocks(SIZE)) for each in (log, expected)]
    assert blocks[0].complete and np.allclose(blocks[0].ddq, blocks[1].ddq, atol=1e-9)


def test_given_motion_passes_as_it_is(log):
    motion = {"dq": log.q + 1.0, "ddq": log.q + 2.0, "imu_dgyro": log.imu_gyro + 3.0}
    given = replace(log, **motion)
    (block,) = LogFilter(given).blocks(SIZE)
    assert block.rows == slice(0, SIZE) and (block.q == given.q).all()
    assert (block.dq == given.dq).all() and (block.imu_dgyro == given.imu_dgyro).all()


def test_given_velocities_and_accelerations_go_through_the_window(log):
    given = replace(log, dq=np.ones_like(log.q), ddq=np.full_like(log.q, 2.0))
    (block,) = LogFilter(given).blocks(SIZE)
    assert np.allclose(block.dq, 1.0) and np.allclose(block.ddq, 2.0)


def test_at_a_low_rate_the_window_is_as_wide_as_three_samples(log):
    slow = replace(log, stamp=20_000_000 * np.arange(SIZE))
    found = LogFilter(slow)
    assert found.kernel is not None and found.kernel.side == 3
    (block,) = found.blocks(SIZE)
    assert len(block) == SIZE - 6


def test_a_log_of_counting_encoders_tells_how_wrong_its_accelerations_are(log, robot):
    step = 2.0 * np.pi / 4096
    ramp = np.linspace(0.0, 0.05, SIZE)[:, None] * np.ones(robot.n)
    counted = replace(log, q=step * np.rint(ramp / step))
    told = next(LogFilter(counted).blocks(SIZE)).frame(0).ddq_deviation
    white = Kernel(1e-3, 0.024).noise_gain[2] * step / np.sqrt(12.0)
    assert (told >= white * (1.0 - 1e-9)).all() and (told < 5.0 * white).all()
