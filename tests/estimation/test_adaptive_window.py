import numpy as np
import pytest

from estimation.adaptive_window import AdaptiveWindow
from estimation.differentiation import Differentiator, differentiate

PERIOD = 1e-3  # [s]
STEP = 2.0 * np.pi / 2**16  # [rad] of an encoder of 16 bits
WINDOW = AdaptiveWindow(PERIOD, 0.024, STEP)
TIME = np.arange(300) * PERIOD


def quantised(signal: np.ndarray) -> np.ndarray:
    return np.round(signal / STEP) * STEP


def rest_and_movements() -> np.ndarray:
    """A resting joint, one that drifts, and two that swing at 1 and 4 Hz, (T, 4)."""
    rest = np.full_like(TIME, 0.3)
    swings = [0.4 * np.sin(2.0 * np.pi * frequency * TIME) for frequency in (1.0, 4.0)]
    return quantised(np.stack([rest, 0.3 + 0.001 * TIME, *swings], axis=1))


def windows(samples: np.ndarray, method: AdaptiveWindow):
    return (samples[t - method.length : t] for t in range(method.length, len(samples), 7))


@pytest.mark.parametrize("order", [1, 2])
def test_polynomials_of_the_order_of_the_fit_are_reproduced_exactly(order: int):
    method = AdaptiveWindow(PERIOD, 0.024, STEP, order)
    curvature = np.array([0.0, 0.0] if order == 1 else [4.0, -300.0])
    motion = 0.3 + np.array([-0.7, 5.0]) * TIME[:, None] + 0.5 * curvature * TIME[:, None] ** 2
    value, slope, second = differentiate(motion, method)[:, -1]
    then = TIME[-1] - method.delay
    np.testing.assert_allclose(
        value, 0.3 + np.array([-0.7, 5.0]) * then + 0.5 * curvature * then**2, rtol=1e-12
    )
    np.testing.assert_allclose(slope, np.array([-0.7, 5.0]) + curvature * then, rtol=1e-9)
    np.testing.assert_allclose(second, curvature, atol=1e-7)
    assert (method.chosen_halves(motion[-method.length :]) == method.side).all()


@pytest.mark.parametrize("order", [1, 2])
def test_the_window_is_long_at_rest_and_shrinks_with_the_movement(order: int):
    method = AdaptiveWindow(PERIOD, 0.024, STEP, order)
    chosen = np.array([method.chosen_halves(w) for w in windows(rest_and_movements(), method)])
    rest, drift, slow, fast = chosen.mean(axis=0).T
    assert (rest == method.side).all() and (drift == method.side).all()
    for velocity_or_acceleration in (0, 1):
        at = velocity_or_acceleration
        assert method.side >= slow[at] > 1.3 * fast[at] > method.halves[0]


def test_the_line_takes_a_shorter_window_than_the_parabola():
    method = AdaptiveWindow(PERIOD, 0.024, STEP, order=1)
    for window in windows(rest_and_movements(), method):
        velocity, acceleration = method.chosen_halves(window)
        assert (velocity <= acceleration).all()
    assert velocity[-1] < acceleration[-1]


def worst_residual(window: np.ndarray, half: int, order: int) -> float:
    """Largest distance of a sample from NumPy's own fit on the innermost samples."""
    middle = len(window) // 2
    samples = window[middle - half : middle + half + 1]
    x = np.arange(-half, half + 1) / half
    return float(np.abs(samples - np.polyval(np.polyfit(x, samples, order), x)).max())


@pytest.mark.parametrize("order", [1, 2])
def test_every_sample_of_a_chosen_window_lies_within_the_bound_and_the_next_one_has_one_outside(
    order: int,
):
    method = AdaptiveWindow(PERIOD, 0.024, STEP, order, shortest=1e-3)
    halves = method.halves.tolist()
    stopped = 0
    for window in windows(rest_and_movements(), method):
        for chosen, degree in zip(method.chosen_halves(window), (order, 2), strict=True):
            for column, half in zip(window.T, chosen.tolist(), strict=True):
                assert worst_residual(column, half, degree) <= STEP * (1.0 + 1e-6)
                if half < method.side:
                    longer = halves[halves.index(half) + 1]
                    assert worst_residual(column, longer, degree) > STEP * (1.0 - 1e-6)
                    stopped += 1
    assert stopped > 20


def test_a_jump_keeps_all_windows_that_reach_it_out():
    samples = np.where(TIME < 0.1, 0.0, 100 * STEP)[:, None]
    value, slope, _ = differentiate(samples, WINDOW)
    before = 99 + WINDOW.side - WINDOW.halves[0]  # the last window that ends short of the jump
    assert not np.abs(value[WINDOW.length : before]).max() > STEP
    assert slope[100 + WINDOW.side].item() > 1.0  # the shortest window is taken, fit or not


def test_each_channel_has_a_bound_of_its_own():
    noise = np.random.default_rng(1).normal(size=(WINDOW.length, 1))
    both = AdaptiveWindow(PERIOD, 0.024, np.array([0.5, 6.0]))
    narrow, wide = both.chosen_halves(np.hstack((noise, noise)))[0]
    assert narrow < wide == both.side


def test_neighbours_do_not_change_a_channel():
    samples = rest_and_movements()
    together = differentiate(samples, WINDOW)
    for column in range(samples.shape[1]):
        alone = differentiate(samples[:, [column]], WINDOW)
        np.testing.assert_allclose(alone[..., 0], together[..., column], rtol=0, atol=1e-9)


@pytest.mark.parametrize("order", [1, 2])
def test_the_stream_gives_the_numbers_of_the_log(order: int):
    samples = rest_and_movements()
    method = AdaptiveWindow(PERIOD, 0.024, np.array([1.0, 1.0, 2.0, 0.7]) * STEP, order)
    stream, log = Differentiator(method, samples.shape[1]), differentiate(samples, method)
    for t, sample in enumerate(samples):
        stream.put(sample)
        if stream.full:
            np.testing.assert_allclose(stream.result(), log[:, t], rtol=0, atol=1e-8)
    assert stream.full and stream.delay == 0.024


def test_settings_that_make_no_window_are_refused_with_the_numbers():
    with pytest.raises(ValueError, match=r"delay 0.001 s"):
        AdaptiveWindow(PERIOD, 0.001, STEP)
    with pytest.raises(ValueError, match="bound: expected positive numbers"):
        AdaptiveWindow(PERIOD, 0.024, np.array([STEP, 0.0]))
    with pytest.raises(ValueError, match="order: expected 1 or 2, got 3"):
        AdaptiveWindow(PERIOD, 0.024, STEP, order=3)
