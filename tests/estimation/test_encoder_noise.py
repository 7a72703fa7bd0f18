"""How uncertain accelerations are that come from counting encoders."""

from typing import Any

import numpy as np
import pytest

from estimation.adaptive_window import AdaptiveWindow
from estimation.differentiation import Kernel, differentiate
from estimation.encoder_noise import EncoderNoise
from estimation.sensor_pipeline import SensorPipeline
from tests.estimation.test_sensor_pipeline import ROBOT, raw_frame, run

KERNEL = Kernel(1e-3, 0.024)


def step_of(bits: int) -> float:
    return 2.0 * np.pi / 2**bits


def counted(rate: float, step: float, seconds: float = 4.0) -> np.ndarray:
    """Positions of a joint that passes ``rate`` counts per second, (T, 1) rad."""
    counts = 0.3 + rate * np.arange(0.0, seconds, 1e-3)
    return step * np.rint(counts)[:, None]


def learnt(samples: np.ndarray) -> EncoderNoise:
    noise = EncoderNoise(KERNEL, samples.shape[1])
    for q in samples:
        noise.see(q)
    return noise


@pytest.mark.parametrize("bits", [12, 16])
@pytest.mark.parametrize("rate", [7.3, 18.1, 25.2, 33.7, 71.3, 140.9])
def test_accelerations_of_a_counted_joint_are_as_wrong_as_is_said(bits: int, rate: float) -> None:
    step = step_of(bits)
    samples = counted(rate, step)
    error = differentiate(samples, KERNEL)[2, KERNEL.length :, 0]  # the joint does not accelerate
    told = learnt(samples).deviation(np.array([rate * step]))[0]
    assert error.std() < 1.05 * told
    assert np.abs(error).max() < 2.0 * told


def test_a_slow_joint_is_four_times_as_uncertain_as_a_fast_one() -> None:
    step = step_of(12)
    noise = learnt(counted(20.0, step))
    slow, fast = (float(noise.deviation(np.array([rate * step]))[0]) for rate in (20.0, 140.0))
    assert slow / fast == pytest.approx(4.0, abs=0.2)
    assert fast == pytest.approx(KERNEL.noise_gain[2] * step / np.sqrt(12.0))


def test_a_single_count_of_a_resting_joint_is_no_surprise() -> None:
    step = step_of(12)
    samples = np.repeat([0.0, step], 200)[:, None]
    error = differentiate(samples, KERNEL)[2, KERNEL.length :, 0]
    told = learnt(samples).deviation(np.zeros(1))[0]
    assert 1.0 < np.abs(error).max() / told < 2.0


def test_a_joint_that_has_not_moved_counts_as_the_coarsest_of_the_others() -> None:
    samples = np.zeros((3, 3))
    samples[1:, 0], samples[2:, 1] = 1e-3, 2e-3
    samples[2, 0] = 4e-3  # three counts at once
    assert learnt(samples).step == pytest.approx([1e-3, 2e-3, 2e-3])
    assert learnt(np.zeros((3, 3))).step == pytest.approx(0.0)


def test_frames_tell_how_wrong_their_accelerations_are() -> None:
    pipeline = SensorPipeline(ROBOT)
    told = run(pipeline, 0, 80).ddq_deviation
    assert told is not None  # raw_frame moves joint i by (i + 1) mrad from frame to frame
    white = KERNEL.noise_gain[2] / np.sqrt(12.0) * 1e-3 * np.array([1.0, 2.0, 3.0])
    assert (told >= white * (1.0 - 1e-9)).all() and (told < 5.0 * white).all()


def test_frames_tell_nothing_where_it_is_not_known() -> None:
    measured = SensorPipeline(ROBOT).step(raw_frame(0, direct=True), 0)
    assert measured.ddq_deviation is None
    bound: Any = 1e-4
    adaptive = SensorPipeline(ROBOT, method=lambda p, d: AdaptiveWindow(p, d, bound))
    assert run(adaptive, 0, 80).ddq_deviation is None
