"""Velocity and acceleration from encoders: errors, delays and cost of the three methods.

Joints that drift, swing and halt are read through encoders of 16 and 12 bits per turn at 1 kHz.
Errors are RMS against the exact motion of the instant that a method describes, `delay` ago; on
the halt, from 0.5 rad/s within 20 ms, over the 0.1 s around it. Bounds and noise are those of
the encoder, the rest is the sensor server's default; the Kalman filter remembers 48 ms. The
delay is measured by the phase of a swing of 2 Hz without quantisation. A step takes one sample
of all of iCub's channels and differentiates.
"""

from collections.abc import Callable
from time import perf_counter_ns

import numpy as np

from benchmarks.rows import Row, row
from estimation.adaptive_window import AdaptiveWindow
from estimation.differentiation import Array, Differentiator, Kernel, Method, differentiate
from estimation.kalman_window import KalmanWindow
from estimation.sensor_pipeline import column_values
from robot_model import load_robot
from services.sensor_server.config import FilterConfig

PERIOD = 1e-3  # s
DURATION = 4.0  # s
HALT, BRAKING, AROUND = 2.0, 0.02, 0.05  # s: when, how long, and what is looked at
DELAYS = (0.024, 0.012)  # s
ROUNDS, BURST = 60, 50
Signal = Callable[[Array], Array]  # times (T,) to position, velocity, acceleration (3, T)


def run(quick: bool = False) -> list[Row]:
    """Return errors and delays, which are the same in every run, and the median costs."""
    rows = [figure for bits in (16, 12) for figure in _errors(bits)]
    rows += [figure for bits in (16, 12) for figure in _delays(bits)]
    return rows + _costs(5 if quick else ROUNDS)


def _methods(bits: int) -> dict[str, Method]:
    """The methods for joints with encoders of some bits per turn, by name and delay."""
    step, defaults = 2.0 * np.pi / 2**bits, FilterConfig().kalman
    methods: dict[str, Method] = {}
    for delay in DELAYS:
        ms = f"{delay * 1e3:.0f} ms"
        methods[f"triweight, {ms}"] = Kernel(PERIOD, delay)
        methods[f"adaptive, order 2, {ms}"] = AdaptiveWindow(PERIOD, delay, step)
        methods[f"adaptive, order 1, {ms}"] = AdaptiveWindow(PERIOD, delay, step, order=1)
        noise, memory = step / np.sqrt(12.0), defaults.memory
        methods[f"Kalman, {ms}"] = KalmanWindow(PERIOD, delay, noise, defaults.jerk, memory)
    return methods


def _swing(amplitude: float, frequency: float) -> Signal:
    omega = 2.0 * np.pi * frequency
    scale = amplitude * omega ** np.arange(3)[:, None]
    return lambda t: scale * np.stack([np.sin(omega * t), np.cos(omega * t), -np.sin(omega * t)])


def _drift(t: Array) -> Array:
    return np.stack([0.01 * t, np.full_like(t, 0.01), np.zeros_like(t)])


def _halt(t: Array) -> Array:
    """Half a cosine of velocity, from 0.5 rad/s to rest."""
    x = np.clip((t - HALT) / BRAKING, 0.0, 1.0)
    speed, rate = 0.5, np.pi / BRAKING
    braked = 0.5 * speed * BRAKING * (x + np.sin(np.pi * x) / np.pi)
    return np.stack(
        [
            speed * np.minimum(t - HALT, 0.0) + braked,
            0.5 * speed * (1.0 + np.cos(np.pi * x)),
            -0.5 * speed * rate * np.sin(np.pi * x) * ((x > 0.0) & (x < 1.0)),
        ]
    )


SIGNALS: dict[str, Signal] = {
    "drift 0.01 rad/s": _drift,
    "0.3 rad, 0.5 Hz": _swing(0.3, 0.5),
    "0.3 rad, 1 Hz": _swing(0.3, 1.0),
    "0.3 rad, 2 Hz": _swing(0.3, 2.0),
    "0.1 rad, 4 Hz": _swing(0.1, 4.0),
    "halt": _halt,
}


def _errors(bits: int) -> list[Row]:
    table = f"{bits} bits, RMS errors in rad/s and rad/s^2"
    rows = []
    for name, method in _methods(bits).items():
        for signal, motion in SIGNALS.items():
            of_velocity, of_acceleration = _error(method, motion, bits)
            cell = (table, name, signal)
            rows.append(row(f"{name}, {signal}, velocity", of_velocity, "rad/s", cell=cell))
            rows.append(
                row(f"{name}, {signal}, acceleration", of_acceleration, "rad/s^2", cell=cell)
            )
    return rows


def _error(method: Method, motion: Signal, bits: int) -> Array:
    time = np.arange(0.0, DURATION, PERIOD)
    step = 2.0 * np.pi / 2**bits
    measured = np.round(motion(time)[0] / step) * step
    described = time - method.delay
    error = differentiate(measured[:, None], method)[1:, :, 0] - motion(described)[1:]
    looked_at = np.arange(len(time)) >= method.length
    if motion is _halt:
        looked_at &= np.abs(described - HALT - BRAKING / 2.0) < AROUND
    return np.sqrt(np.mean(error[:, looked_at] ** 2, axis=1))


def _delays(bits: int) -> list[Row]:
    table = f"Delay in ms at 2 Hz, made for {bits} bits"
    return [
        row(f"{name}, {bits} bits, {column}", value, "ms", cell=(table, name, column))
        for name, method in _methods(bits).items()
        for column, value in _delay(method).items()
    ]


def _delay(method: Method) -> dict[str, float]:
    """The stated delay, and what the phases of velocity and acceleration tell at 2 Hz [ms]."""
    time, omega = np.arange(0.0, 2.0, PERIOD), 2.0 * np.pi * 2.0
    motion, end = _swing(0.3, 2.0)(time), slice(-1000, None)
    phasor = np.exp(-1j * omega * time[end])
    found = differentiate(motion[0][:, None], method)[1:, end, 0] @ phasor
    lags = 1e3 * np.angle(motion[1:, end] @ phasor / found) / omega
    return {"stated": 1e3 * method.delay, "velocity": lags[0], "acceleration": lags[1]}


def _costs(rounds: int) -> list[Row]:
    """Median time [us] of a sample of all channels; the methods take turns."""
    robot, config = load_robot("icub"), FilterConfig()
    bound = column_values(robot, **config.adaptive.bound.model_dump())
    samples = np.random.default_rng(0).normal(size=(BURST, len(bound))) * 0.3 * bound
    methods: dict[str, Method] = {
        "triweight": Kernel(PERIOD, config.delay),
        "adaptive, order 2": AdaptiveWindow(PERIOD, config.delay, bound),
        "adaptive, order 1": AdaptiveWindow(PERIOD, config.delay, bound, order=1),
        "Kalman": KalmanWindow(PERIOD, config.delay, **config.kalman.model_dump()),
    }
    streams = {name: Differentiator(method, len(bound)) for name, method in methods.items()}
    times: dict[str, list[int]] = {name: [] for name in streams}
    for _ in range(rounds):
        for name, stream in streams.items():
            times[name] += _times(stream, samples)
    label = f"a sample of {len(bound)} channels"
    return [row(f"{name}, {label}", float(np.median(t)) * 1e-3, "us") for name, t in times.items()]


def _times(stream: Differentiator, samples: Array) -> list[int]:
    """Durations of hot steps [ns]; the first of a burst warms the caches and is dropped."""
    times = []
    for sample in samples:
        start = perf_counter_ns()
        stream.put(sample)
        stream.result()
        times.append(perf_counter_ns() - start)
    return times[1:]
