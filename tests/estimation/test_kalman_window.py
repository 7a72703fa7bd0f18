import numpy as np
import pytest
from scipy.linalg import cholesky, solve_discrete_are

from estimation.differentiation import Differentiator, differentiate
from estimation.kalman_window import KalmanWindow

PERIOD = 1e-3  # [s]
NOISE, JERK = 2.8e-5, 10.0  # [rad], [rad/s^3 per root of Hz]
FILTER = KalmanWindow(PERIOD, 0.012, NOISE, JERK, 0.048)
STEP = np.array([[1.0, PERIOD, PERIOD**2 / 2.0], [0.0, 1.0, PERIOD], [0.0, 0.0, 1.0]])
READ = np.array([1.0, 0.0, 0.0])


def process_noise() -> np.ndarray:
    """Covariance of what white jerk adds to value and derivatives in one period, (3, 3)."""
    p = PERIOD
    upper = [[p**5 / 20, p**4 / 8, p**3 / 6], [p**4 / 8, p**3 / 3, p**2 / 2]]
    return JERK**2 * np.array([*upper, [p**3 / 6, p**2 / 2, p]])


def recursion(samples: np.ndarray, lag: int) -> tuple[np.ndarray, np.ndarray]:
    """The textbook: a filter that knows nothing at first, then a smoother back by the lag."""
    state, covariance = np.zeros(3), np.diag([1e2, 1e4, 1e8])
    history = []
    for sample in samples:
        if history:
            state, covariance = STEP @ state, STEP @ covariance @ STEP.T + process_noise()
        predicted = state, covariance
        gain = covariance @ READ / (READ @ covariance @ READ + NOISE**2)
        state = state + gain * (sample - READ @ state)
        kept = np.eye(3) - np.outer(gain, READ)
        covariance = kept @ covariance @ kept.T + NOISE**2 * np.outer(gain, gain)
        history.append((predicted, (state, covariance)))
    for at in range(len(samples) - 2, len(samples) - 2 - lag, -1):
        (ahead, spread), (own, before) = history[at + 1][0], history[at][1]
        back = np.linalg.solve(spread, STEP @ before).T
        state = own + back @ (state - ahead)
        covariance = before + back @ (covariance - spread) @ back.T
    return state, covariance


@pytest.mark.parametrize("lag", [0, 5, 24, 40])
def test_the_weights_are_those_of_filter_and_smoother_in_recursion(lag: int):
    method = KalmanWindow(PERIOD, lag * PERIOD, NOISE, JERK, 0.048)
    samples = np.cumsum(np.random.default_rng(lag).normal(scale=1e-3, size=method.length))
    state, covariance = recursion(samples, lag)
    scale = np.sqrt(np.diag(method.covariance))
    np.testing.assert_allclose(method.of(samples[:, None])[:, 0] / scale, state / scale, atol=0.02)
    np.testing.assert_allclose(np.diag(covariance), np.diag(method.covariance), rtol=1e-3)


def test_with_a_long_memory_the_covariance_is_the_stationary_one():
    stationary = solve_discrete_are(STEP.T, READ[:, None], process_noise(), [[NOISE**2]])
    gain = stationary @ READ / (stationary[0, 0] + NOISE**2)
    filtered = stationary - np.outer(gain, READ @ stationary)
    long = KalmanWindow(PERIOD, 0.0, NOISE, JERK, 0.15)
    np.testing.assert_allclose(long.covariance, filtered, rtol=1e-4)


def test_the_memory_of_the_settings_is_long_enough_to_be_nearly_stationary():
    long = KalmanWindow(PERIOD, 0.012, NOISE, JERK, 0.15)
    ratio = np.diag(FILTER.covariance) / np.diag(long.covariance)
    assert (ratio >= 1.0).all() and (ratio < 1.02).all()


def test_errors_on_simulated_motions_have_the_stated_covariance():
    rng, runs = np.random.default_rng(3), 4000
    root = cholesky(process_noise(), lower=True)
    states = np.zeros((FILTER.length, 3, runs))
    for t in range(1, FILTER.length):
        states[t] = STEP @ states[t - 1] + root @ rng.normal(size=(3, runs))
    samples = states[:, 0] + rng.normal(scale=NOISE, size=(FILTER.length, runs))
    error = FILTER.of(samples) - states[-1 - FILTER.side]
    scale = np.sqrt(np.diag(FILTER.covariance))
    measured = np.cov(error / scale[:, None])
    expected = FILTER.covariance / np.outer(scale, scale)
    np.testing.assert_allclose(measured, expected, atol=0.08)


@pytest.mark.parametrize("delay", [0.0, 0.012, 0.024, 0.048 - 3e-3])
def test_a_parabola_has_its_derivatives_at_the_stated_delay(delay: float):
    method = KalmanWindow(PERIOD, delay, NOISE, JERK, 0.048)
    time = np.arange(100) * PERIOD
    parabola = 0.3 - 0.7 * time + 2.0 * time**2
    value, slope, curvature = differentiate(parabola[:, None], method)[:, -1, 0]
    then = time[-1] - method.delay
    assert value == pytest.approx(0.3 - 0.7 * then + 2.0 * then**2, abs=1e-10)
    assert slope == pytest.approx(-0.7 + 4.0 * then, abs=1e-8)
    assert curvature == pytest.approx(4.0, abs=1e-5)


def test_the_longer_the_lag_the_less_noise():
    lags = [KalmanWindow(PERIOD, lag, NOISE, JERK, 0.048) for lag in (0.0, 0.006, 0.012, 0.024)]
    stated = np.array([np.diag(method.covariance) for method in lags])
    assert (np.diff(stated, axis=0) < 0.0).all()


@pytest.mark.parametrize("lag", [0.0, 0.004, 0.008, 0.012, 0.024])
def test_the_lateness_is_what_the_phase_of_slow_accelerations_says(lag: float):
    method, frequency = KalmanWindow(PERIOD, lag, NOISE, JERK, 0.048), 0.1
    gain = method.response(frequency)[2] / (2j * np.pi * frequency) ** 2
    late = -np.angle(gain) / (2.0 * np.pi * frequency)
    assert method.lateness == pytest.approx(late, abs=1e-6)


def test_only_the_middle_of_the_memory_has_no_lateness():
    middle, coarse = (
        KalmanWindow(PERIOD, lag, 16 * NOISE, JERK, 0.048).lateness for lag in (0.024, 0.012)
    )
    assert abs(middle) < 1e-9 and coarse > 0.01  # s: 12 bits need a longer lag


@pytest.mark.parametrize("frequency", [0.5, 2.0, 4.0])
def test_the_three_rows_are_nearly_one_filter(frequency: float):
    value, slope, curvature = FILTER.response(frequency)
    s = 2j * np.pi * frequency
    assert abs(value - 1.0) < 1e-3
    assert abs(slope / (s * value) - 1.0) < 0.01
    assert abs(curvature / (s**2 * value) - 1.0) < 0.05


def test_the_stream_gives_the_numbers_of_the_log():
    samples = np.random.default_rng(0).normal(scale=NOISE, size=(150, 7))
    stream, log = Differentiator(FILTER, 7), differentiate(samples, FILTER)
    for t, sample in enumerate(samples):
        stream.put(sample)
        if stream.full:
            np.testing.assert_allclose(stream.result(), log[:, t], rtol=0, atol=1e-9)
    assert stream.full and stream.delay == 0.012


def test_settings_that_make_no_filter_are_refused_with_the_numbers():
    with pytest.raises(ValueError, match="beyond the delay of 0.048 s, got 0.048 s"):
        KalmanWindow(PERIOD, 0.048, NOISE, JERK, 0.048)
    with pytest.raises(ValueError, match="must be positive"):
        KalmanWindow(PERIOD, 0.012, 0.0, JERK, 0.048)
