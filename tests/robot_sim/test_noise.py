"""Noise profiles: as large as DESIGN says, drawn by the seed, and reproduced by reset."""

import numpy as np
import pytest

from robot_sim import Plant
from robot_sim.noise import BLOCK, Noise, load_profile

SIZES = (32, 6, 1)


def samples(profile, channel, count=20_000, seed=3):
    noise = Noise(load_profile(profile), *SIZES, seed)
    drawn = []
    for _ in range(count):
        drawn.append(noise.errors[channel].copy())
        noise.draw()
    return np.array(drawn)


@pytest.mark.parametrize(
    ("channel", "white", "bias"),
    [
        ("ft", [0.25] * 3 + [0.01] * 3, [2.0] * 3 + [0.06] * 3),
        ("motor_torque", 0.1, 0.3),
        ("gyro", 0.005, 0.01),
        ("accelerometer", 0.02, 0.05),
        ("orientation", 0.001, 0.0),
    ],
)
def test_the_realistic_profile_has_the_stated_white_noise_and_biases(channel, white, bias):
    drawn = samples("realistic", channel)
    white, bias = np.broadcast_arrays(white, bias, drawn[0])[:2]
    mean = np.abs(drawn.mean(axis=0))
    assert drawn.std(axis=0) == pytest.approx(white, rel=0.05)
    assert (mean <= bias + 5 * white / np.sqrt(len(drawn))).all()
    assert mean.max() >= 0.05 * bias.max()


def test_errors_drawn_for_many_ticks_at_once_are_those_drawn_one_by_one():
    drawn = samples("realistic", "gyro", count=2 * BLOCK + 3, seed=4)
    noise = Noise(load_profile("realistic"), *SIZES, 4)
    random, size = np.random.default_rng(4), len(noise.bias)
    random.standard_normal(size)  # the biases
    one_by_one = np.array([random.standard_normal(size) for _ in drawn])
    gyro = 6 * 6 + 32 + np.arange(3)
    expected = noise.bias[gyro] + 0.005 * one_by_one[:, gyro]
    assert drawn[:, 0] == pytest.approx(expected, abs=1e-15)


def test_biases_over_many_runs_are_normal_with_half_the_bound_and_cut_at_it():
    profile = load_profile("realistic")
    noises = [Noise(profile, *SIZES, seed) for seed in range(500)]
    biases = np.array([noise.bias[:36].reshape(6, 6)[:, :3] for noise in noises])  # N
    assert np.abs(biases).max() <= 2.0
    assert biases.std() == pytest.approx(1.0, rel=0.1)  # the cut takes 5 %


@pytest.mark.parametrize(("profile", "bits"), [("realistic", 16), ("realistic_12bit", 12)])
def test_encoders_count_in_steps_and_nothing_else_is_delivered(robot, profile, bits):
    plant = Plant(robot, profile=profile)
    plant.step()
    raw = plant.raw()
    counts = raw.q / (2 * np.pi / 2**bits)
    assert counts == pytest.approx(np.rint(counts), abs=1e-6)
    assert np.abs(raw.q - plant.q).max() <= np.pi / 2**bits
    assert raw.dq is None and raw.ddq is None and raw.imu_dgyro is None


def test_the_ideal_profile_delivers_exactly_the_truth(robot):
    plant = Plant(robot)
    for _ in range(5):
        plant.step()
    raw, truth = plant.raw(), plant.truth()
    for name in ("q", "dq", "ddq", "motor_torque", "ft"):
        assert np.array_equal(getattr(raw, name), getattr(truth, name)), name
    assert raw.imu_dgyro is not None
    assert raw.joint_valid.all() and raw.ft_valid.all() and raw.imu_valid.all()


def test_coulomb_friction_acts_only_where_the_profile_says_so(robot):
    from dataclasses import replace

    rough = replace(robot, coulomb=np.full(robot.n, 0.5))

    def torques(profile):
        plant = Plant(rough, base="fixed", profile=profile)
        for _ in range(50):
            plant.step()
        exact = plant.readings
        smooth = exact.link_torque + rough.rotor_inertia @ exact.ddq + rough.viscous * exact.dq
        return exact.motor_torque - smooth, exact.dq

    friction, _ = torques("realistic")
    assert np.abs(friction).max() < 1e-12
    friction, dq = torques("realistic_friction")
    moving = np.abs(dq) > 0.05
    assert friction[moving] == pytest.approx(0.5 * np.sign(dq[moving]), rel=0.05)


def record(plant, ticks):
    frames = []
    for _ in range(ticks):
        plant.step()
        raw, truth = plant.raw(), plant.truth()
        frames.append(np.hstack([raw.q, raw.ft.ravel(), raw.imu_acc[0], truth.ddq]))
    return np.array(frames)


def test_equal_seeds_give_equal_runs_and_other_seeds_other_noise(robot):
    first, second, other = (
        record(Plant(robot, profile="realistic", seed=seed), 50) for seed in (1, 1, 2)
    )
    assert np.array_equal(first, second)
    assert not np.array_equal(first, other)


def test_reset_reproduces_the_run_bit_by_bit(robot):
    plant = Plant(robot, profile="realistic", seed=5)

    def pushed():
        plant.push("chest", np.zeros(3), np.array([40.0, 0.0, 0.0]), "world", "hold", 0.2)
        plant.command(robot.home + 0.05, np.full(robot.n, 0.2))
        return record(plant, 300)

    first = pushed()
    plant.reset()
    assert plant.time == 0 and not plant.pushes
    assert np.array_equal(first, pushed())


def test_an_unknown_profile_is_an_error_that_lists_those_that_exist(robot):
    with pytest.raises(LookupError, match="'realistc' not found; did you mean 'realistic'"):
        Plant(robot, profile="realistc")


def test_a_profile_file_with_an_unknown_key_is_an_error_that_names_it(tmp_path):
    file = tmp_path / "mine.yaml"
    file.write_text("gyro: {white: 0.1, drift: 2}\n")
    with pytest.raises(ValueError, match="mine.yaml: gyro.drift"):
        load_profile(file)
