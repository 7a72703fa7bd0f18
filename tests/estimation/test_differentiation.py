import numpy as np
import pytest

from estimation.differentiation import Differentiator, Kernel, differentiate

PERIOD = 1e-3  # [s]
KERNEL = Kernel(PERIOD, 0.024)


def quantised(signal: np.ndarray, bits: int) -> np.ndarray:
    step = 2.0 * np.pi / 2**bits
    return np.round(signal / step) * step


def movement(time: np.ndarray) -> np.ndarray:
    """An arm's movement at 0.5 Hz: position, velocity, acceleration, (3, T)."""
    omega, amplitude = 2.0 * np.pi * 0.5, 0.3  # [rad/s], [rad]
    phase = omega * time
    scale = amplitude * np.array([1.0, omega, -(omega**2)])
    return scale[:, None] * np.array([np.sin(phase), np.cos(phase), np.sin(phase)])


def errors(bits: int | None, kernel: Kernel) -> np.ndarray:
    """RMS errors of the three results during the movement, against the delayed truth, (3,)."""
    time = np.arange(0.0, 4.0, PERIOD)
    truth = movement(time - kernel.delay)
    measured = movement(time)[0]
    measured = measured if bits is None else quantised(measured, bits)
    result = differentiate(measured[:, None], kernel)[:, kernel.length - 1 :, 0]
    return np.sqrt(np.mean((result - truth[:, kernel.length - 1 :]) ** 2, axis=1))


def test_a_parabola_has_its_derivatives_at_the_stated_delay():
    time = np.arange(200) * PERIOD
    parabola = 0.3 - 0.7 * time + 2.0 * time**2
    value, slope, curvature = differentiate(parabola[:, None], KERNEL)[:, -1, 0]
    then = time[-1] - KERNEL.delay
    assert slope == pytest.approx(-0.7 + 4.0 * then, abs=1e-11)
    assert curvature == pytest.approx(4.0, abs=1e-9)
    variance = (value - (0.3 - 0.7 * then + 2.0 * then**2)) / 2.0
    assert variance == pytest.approx((25 * PERIOD) ** 2 / 9.0, rel=0.01)  # the triweight's h^2/9


@pytest.mark.parametrize("frequency", [0.5, 2.0, 5.0, 10.0])
def test_the_three_rows_are_one_filter(frequency: float):
    value, slope, curvature = KERNEL.response(frequency)
    s = 2j * np.pi * frequency
    assert abs(value.imag) < 1e-12  # linear phase: the delay is the same at every frequency
    assert slope == pytest.approx(s * value, rel=1e-6)
    assert curvature == pytest.approx(s**2 * value, rel=1e-6)


def test_the_gain_falls_to_seven_tenths_where_the_docstring_says():
    assert abs(KERNEL.response(0.38 / KERNEL.delay)[0]) == pytest.approx(0.7, abs=0.01)


def test_white_noise_comes_out_with_the_stated_gain():
    noise = np.random.default_rng(5).normal(size=(20_000, 4))
    result = differentiate(noise, KERNEL)[:, KERNEL.length :]
    assert result.std(axis=(1, 2)) == pytest.approx(KERNEL.noise_gain, rel=0.05)


def test_a_slow_movement_is_followed_exactly_without_quantisation():
    value, slope, curvature = errors(None, KERNEL)
    assert value < 1.1e-4 and slope < 3.2e-4 and curvature < 1.0e-3  # 0.03 % of the amplitudes


def test_sixteen_bits_give_accelerations_below_a_hundredth_of_gravity():
    value, slope, curvature = errors(16, KERNEL)
    assert value < 1.1e-4  # [rad]
    assert slope < 6e-4  # [rad/s]
    assert curvature < 0.06  # [rad/s^2], 0.05 predicted from white quantisation noise


def test_twelve_bits_give_a_tenth_of_gravity_and_a_longer_window_helps():
    assert errors(12, KERNEL)[2] < 1.0  # [rad/s^2]
    assert errors(12, Kernel(PERIOD, 0.048))[2] < 0.2


def test_the_stream_gives_the_numbers_of_the_log():
    samples = np.random.default_rng(0).normal(size=(150, 7))
    stream = Differentiator(KERNEL, 7)
    log = differentiate(samples, KERNEL)
    for t, sample in enumerate(samples):
        stream.put(sample)
        if stream.full:
            np.testing.assert_allclose(stream.result(), log[:, t], rtol=0, atol=1e-10)
    assert stream.full


def test_a_log_shorter_than_the_window_has_no_results():
    assert not differentiate(np.ones((20, 2)), KERNEL).any()


def test_the_newest_and_the_extrapolated_sample_follow_the_line():
    stream = Differentiator(KERNEL, 1)
    for t in range(KERNEL.length + 3):
        stream.put(np.array([2.0 * t]))
    assert stream.newest[0] == 2.0 * (KERNEL.length + 2)
    assert stream.extrapolated[0] == 2.0 * (KERNEL.length + 3)


def test_the_window_is_not_full_after_a_reset():
    stream = Differentiator(KERNEL, 1)
    for _ in range(KERNEL.length):
        stream.put(np.zeros(1))
    assert stream.full
    stream.reset()
    assert not stream.full


@pytest.mark.parametrize(("period", "delay"), [(0.0, 0.02), (1e-3, 1e-3), (-1e-3, 0.02)])
def test_a_window_too_short_is_refused_with_the_numbers(period: float, delay: float):
    with pytest.raises(ValueError, match=f"delay {delay} s"):
        Kernel(period, delay)
