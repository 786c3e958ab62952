"""Lines of a spectrum, and orders at a stated speed, against sinusoids that were put in."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.typing import NDArray

from benchtool.analysis import orders_at_speed, spectral_lines
from benchtool.analysis.lines import lines
from benchtool.analysis.orders.orders import describe_orders
from benchtool.block import Block
from benchtool.errors import AnalysisError
from tests.at_length import at_length

Floats = NDArray[np.float64]

RATE_HZ, COUNT = 5_000.0, 8_000
TIME_S = np.arange(COUNT) / RATE_HZ


def torque(*lines: tuple[float, float], noise: float = 1e-3, seed: int = 0) -> Block:
    random = np.random.default_rng(seed)
    values = 1.5 + noise * random.standard_normal(COUNT)
    for frequency_Hz, amplitude in lines:
        values += amplitude * np.cos(2 * np.pi * frequency_Hz * TIME_S + random.uniform(0, 6.28))
    return Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=values)


@given(frequency_Hz=st.floats(10.0, 2_400.0), amplitude=st.floats(0.02, 2.0))
@settings(max_examples=30, deadline=None)
def test_a_line_is_found_between_bins(frequency_Hz: float, amplitude: float) -> None:
    found = spectral_lines(torque((frequency_Hz, amplitude), noise=1e-4), "torque").measurements
    assert found[0].value == pytest.approx(frequency_Hz, abs=0.01)
    assert found[1].value == pytest.approx(amplitude, rel=2e-3)


def test_lines_are_listed_by_size_and_noise_is_not() -> None:
    (table,) = spectral_lines(torque((120.0, 0.1), (240.3, 0.3), (33.3, 0.02)), "torque").tables
    assert [round(row[0], 1) for row in table.rows] == [240.3, 120.0, 33.3]


def test_of_two_equal_lines_none_is_the_largest() -> None:
    found = spectral_lines(torque((120.0, 0.1), (240.3, 0.1), noise=0.02), "torque")
    assert np.isnan(found.measurements[0].value)
    assert "Nm, are equally large within their uncertainty" in found.measurements[0].reason
    assert found.measurements[1].value == pytest.approx(0.1, rel=0.02)
    assert len(found.tables[0].rows) == 2


@pytest.mark.parametrize("seed", [*range(3), *at_length(*range(3, 6))])
def test_looking_at_fewer_maxima_finds_the_same_lines(seed: int, monkeypatch: pytest.MonkeyPatch) -> None:
    block = torque((33.3, 0.02), (1200.7, 0.004), (2400.0, 0.003), noise=0.05, seed=seed)
    few = spectral_lines(block, "torque")
    monkeypatch.setattr(lines, "_candidates", lines._peaks)
    assert repr(spectral_lines(block, "torque")) == repr(few)


def test_noise_has_no_lines() -> None:
    for seed in range(20):
        found = spectral_lines(torque(noise=0.1, seed=seed), "torque").measurements
        assert all(
            np.isnan(each.value) and each.reason == "no line stands out of the noise" for each in found
        )


def test_a_line_of_what_none_is_said_to_have_stands_out() -> None:
    """And the bound is not many times what would."""
    below = [
        each.below
        for seed in range(20)
        for each in spectral_lines(torque(noise=0.1, seed=seed), "torque").measurements[1:]
    ]
    bound = max(each for each in below if each is not None)
    assert len(below) == 20
    for frequency_Hz in (33.3, 240.17, 1200.5):
        for seed in range(8):
            (_, amplitude) = spectral_lines(
                torque((frequency_Hz, bound), noise=0.1, seed=seed), "torque"
            ).measurements
            assert np.isfinite(amplitude.value)
    (_, amplitude) = spectral_lines(torque((240.0, 0.4 * bound), noise=0.1), "torque").measurements
    assert np.isnan(amplitude.value)


def test_red_noise_has_no_lines_either() -> None:
    found = 0
    for seed in range(40):
        walk = np.cumsum(np.random.default_rng(seed).standard_normal(COUNT)) * 1e-3
        block = Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=1.5 + walk)
        found += np.isfinite(spectral_lines(block, "torque").measurements[1].value)
    assert found <= 2


@pytest.mark.parametrize("sidebands_Hz", [2.5, 3.1, 4.0])
def test_sidebands_to_both_sides_are_no_noise_of_the_carrier(sidebands_Hz: float) -> None:
    beta = 1.2  # of a speed that swings: carrier 0.671, sidebands 0.498
    turned = 2 * np.pi * 240.2 * TIME_S + beta * np.sin(2 * np.pi * sidebands_Hz * TIME_S + 0.4)
    values = 1.5 + 0.05 * np.cos(turned) + 1e-3 * np.random.default_rng(3).standard_normal(COUNT)
    block = Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=values)
    frequency, amplitude = spectral_lines(block, "torque").measurements
    assert frequency.uncertainty is not None
    assert abs(frequency.value - 240.2) < 4.0 * frequency.uncertainty.standard
    assert "between its sidebands" in frequency.definition
    assert amplitude.value == pytest.approx(0.05 * 0.671133, abs=1.5e-3)
    assert amplitude.uncertainty is None
    assert "as of a line whose phase swings" in amplitude.uncertainty_reason


@pytest.mark.parametrize("beta", [5.0, 40.0])
def test_a_phase_that_turns_round_is_not_said_to_swing(beta: float) -> None:
    """It was said to swing by 14 rad rms, which is the course of no phase within a turn."""
    turned = beta * np.sin(2 * np.pi * 4.0 * TIME_S + 0.4)
    _, amplitude = spectral_lines(changing(np.full(COUNT, 0.05), turned, 1e-3, 3), "torque").measurements
    assert "as of a line whose phase turns round within the record, or of several lines" in (
        amplitude.uncertainty_reason
    )
    assert "rad rms" not in amplitude.uncertainty_reason


def test_sidebands_of_an_amplitude_that_swings_leave_the_carrier_as_it_is() -> None:
    size = 0.05 * (1.0 + 0.4 * np.cos(2 * np.pi * 3.1 * TIME_S + 0.3))
    values = 1.5 + size * np.cos(2 * np.pi * 240.2 * TIME_S)
    values += 1e-3 * np.random.default_rng(3).standard_normal(COUNT)
    block = Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=values)
    frequency, amplitude = spectral_lines(block, "torque").measurements
    assert "between its sidebands" not in frequency.definition
    assert amplitude.uncertainty is not None
    assert abs(amplitude.value - 0.05) < 4.0 * amplitude.uncertainty.standard


def changing(size: Floats, turned_rad: Floats, noise: float, seed: int) -> Block:
    """A line of 240.2 Hz with a course of its amplitude and of its phase, each shape (COUNT,)."""
    noisy = 1.5 + noise * np.random.default_rng(seed).standard_normal(COUNT)
    line = size * np.cos(2 * np.pi * 240.2 * TIME_S + turned_rad)
    return Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=noisy + line)


AT = TIME_S / TIME_S[-1]
STEADY = np.zeros(COUNT)


@pytest.mark.parametrize(
    ("size", "turned_rad"),
    [
        (0.1 * np.exp(-8.0 * AT), STEADY),
        (0.1 + STEADY, np.pi * 5.0 * (AT**2 - AT)),
        *at_length((0.1 * np.exp(-0.6 * AT), STEADY), (0.1 + STEADY, np.pi * 0.6 * (AT**2 - AT))),
    ],
    ids=["rings down", "drifts", "decays", "drifts little"],
)
def test_of_a_line_that_changes_evenly_the_mean_frequency_is_known(size: Floats, turned_rad: Floats) -> None:
    within = 0
    for seed in range(20):
        frequency, amplitude = spectral_lines(changing(size, turned_rad, 2e-3, seed), "torque").measurements
        assert frequency.uncertainty is not None
        assert frequency.uncertainty.standard < 0.01
        within += abs(frequency.value - 240.2) <= frequency.uncertainty.expanded
        if size[0] > 2.0 * size[-1]:
            assert "changes within the record" in amplitude.reason
        else:
            assert amplitude.uncertainty is not None
            assert abs(amplitude.value - np.mean(size)) < 4.0 * amplitude.uncertainty.standard
    assert within >= 17


@pytest.mark.parametrize(
    ("size", "turned_rad"),
    [
        (0.1 * (AT > 0.4), STEADY),
        (0.1 + STEADY, 2.0 * (AT > 0.4)),
        (0.1 + STEADY, 8.0 * np.maximum(AT - 0.6, 0.0)),
    ],
    ids=["begins late", "phase jumps", "speed steps"],
)
def test_a_line_that_changes_otherwise_is_refused(size: Floats, turned_rad: Floats) -> None:
    found = spectral_lines(changing(size, turned_rad, 2e-3, 1), "torque")
    for each in found.measurements:
        assert np.isnan(each.value)
        assert "wider than that of a steady sinusoid" in each.reason
    assert np.isnan(found.tables[0].rows[0][2:]).all()


@pytest.mark.parametrize("apart", [1.2, 2.1, 3.4])
def test_two_lines_in_one_main_lobe_are_told_apart(apart: float) -> None:
    bin_Hz = RATE_HZ / COUNT
    for seed in range(5):
        block = torque((240.2, 0.1), (240.2 + apart * bin_Hz, 0.06), noise=2e-3, seed=seed)
        for each, truth in zip(spectral_lines(block, "torque").measurements, (240.2, 0.1), strict=True):
            assert each.uncertainty is not None
            assert abs(each.value - truth) < 4.0 * each.uncertainty.standard


def test_a_narrow_band_of_noise_is_no_line() -> None:
    """A resonance of some 50 bins that noise excites: each of its crests would pass for a line."""
    from scipy.signal import lfilter

    found = 0
    for seed in range(20):
        pole = 0.99 * np.exp(2j * np.pi * 300.0 / RATE_HZ)
        noise = np.random.default_rng(seed).standard_normal(COUNT)
        ringing = lfilter([1.0], [1.0, -2.0 * pole.real, abs(pole) ** 2], noise)
        block = Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=1.5 + 1e-3 * ringing)
        found += np.isfinite(spectral_lines(block, "torque").measurements[1].value)
    assert found <= 1


def test_the_stated_intervals_hold_the_truth() -> None:
    within = np.zeros(2)
    for seed in range(30):
        frequency_Hz = 120.0 + 0.0371 * seed
        found = spectral_lines(torque((frequency_Hz, 0.1), noise=0.1, seed=seed), "torque").measurements
        for place, truth in enumerate((frequency_Hz, 0.1)):
            uncertain = found[place].uncertainty
            assert uncertain is not None
            within[place] += abs(found[place].value - truth) <= uncertain.expanded
    assert within.min() >= 26


def test_a_short_record_is_undefined_and_no_error() -> None:
    short = Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=np.arange(20.0))
    assert "at least 64 are needed" in spectral_lines(short, "torque").measurements[0].reason


def test_lines_of_a_clipped_signal_are_refused() -> None:
    clipped = np.minimum(torque((120.0, 0.1), noise=0.01).column("torque"), 1.55)
    found = spectral_lines(Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=clipped), "torque")
    assert all("clipped" in each.reason for each in found.measurements)


@pytest.mark.parametrize("direction", [1.0, -1.0])
def test_orders_at_a_stated_speed(direction: float) -> None:
    omega_m_rad_s = 2 * np.pi * 12.5
    block = torque((24 * 12.5, 0.1), (6 * 12.5, 0.03))
    orders = describe_orders(orders_at_speed(block, "torque", direction * omega_m_rad_s), "torque", 4)
    values = {each.name: each.value for each in orders.measurements}
    assert values["torque_order_largest"] == 24
    assert values["torque_order_24"] == pytest.approx(0.1, rel=5e-3)
    assert values["torque_order_6"] == pytest.approx(0.03, rel=2e-2)
    assert "stated constant speed" in orders.measurements[1].definition


@pytest.mark.parametrize("omega_m_rad_s", [0.0, 1.0])
def test_a_stated_speed_that_makes_no_two_turns_is_refused(omega_m_rad_s: float) -> None:
    with pytest.raises(AnalysisError, match="at least 2 are needed"):
        orders_at_speed(torque((50.0, 0.1)), "torque", omega_m_rad_s)


def test_of_two_lines_in_less_than_a_bin_the_larger_is_within_its_uncertainty() -> None:
    random, within, answered = np.random.default_rng(6), 0, 0
    time = np.arange(4_000) / 4_000
    for _ in range(24):
        turns, apart = random.uniform(100.0, 110.0), random.uniform(0.4, 1.2) * random.choice([-1, 1])
        share, begin = random.uniform(0.05, 0.6), random.uniform(0, 2 * np.pi, 2)
        values = (
            1.0 + 0.1 * np.cos(2 * np.pi * turns * time + begin[0]) + 2e-3 * random.standard_normal(4_000)
        )
        values += 0.1 * share * np.cos(2 * np.pi * (turns + apart) * time + begin[1])
        found = spectral_lines(Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=values), "torque")
        amplitude = found.measurements[1]
        if amplitude.uncertainty is not None:
            answered += 1
            within += abs(amplitude.value - 0.1) < 2.0 * amplitude.uncertainty.standard
    assert answered >= 15
    assert within >= answered - 2


@pytest.mark.parametrize("samples_per_period", [7.0, *at_length(20.0, 12.5)])
def test_steps_that_a_rate_repeats_are_in_the_uncertainty(samples_per_period: float) -> None:
    random, step, errors = np.random.default_rng(4), 2.0 / 2**10, []
    turns = np.arange(round(200 * samples_per_period)) / samples_per_period
    for _ in range(18):
        size = random.uniform(0.4, 1.0)
        values = size * np.cos(2 * np.pi * (turns + random.uniform())) + random.uniform(0.0, step)
        read = step * np.round(values / step)
        block = Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=read)
        amplitude = spectral_lines(block, "torque").measurements[1]
        assert amplitude.uncertainty is not None
        errors.append((amplitude.value - size) / amplitude.uncertainty.standard)
    assert np.sqrt(np.mean(np.square(errors))) < 1.4


def test_a_line_without_anything_beside_it_is_no_error() -> None:
    values = np.tile([0.0, 1.0, 1.0, 0.0, -1.0, -1.0], 100)
    found = spectral_lines(Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=values), "torque")
    assert found.measurements[0].value == pytest.approx(RATE_HZ / 6.0, rel=1e-3)


def test_the_frequency_of_a_line_is_as_uncertain_as_the_rate() -> None:
    block = torque((120.0, 0.1), (240.3, 0.3), noise=1e-4)
    ticks, stamps = spectral_lines(block, "torque"), spectral_lines(block, "torque", rate_relative=0.01)
    for alone, timed in zip(ticks.measurements, stamps.measurements, strict=True):
        assert timed.value == alone.value
    assert ticks.measurements[0].uncertainty is not None
    assert ticks.measurements[0].uncertainty.standard < 0.01
    assert stamps.measurements[0].uncertainty is not None
    assert math.isclose(stamps.measurements[0].uncertainty.standard, 2.403, rel_tol=1e-3)
    assert [each.name for each in stamps.measurements[0].uncertainty.budget][-1] == "sample rate"
    assert stamps.measurements[1].uncertainty == ticks.measurements[1].uncertainty
    np.testing.assert_allclose([row[2] for row in stamps.tables[0].rows], [2.403, 1.2], rtol=1e-3)


@pytest.mark.parametrize("periods", [1.3, 2.2, 2.6])
def test_a_larger_line_that_is_too_slow_for_the_record_leaves_none_as_the_largest(periods: float) -> None:
    random, turns = np.random.default_rng(8), np.arange(4000) / 4000.0
    noise = 1e-3 * random.standard_normal(4000)
    for phase in random.uniform(0.0, 2.0 * np.pi, 8):
        values = np.cos(2 * np.pi * periods * turns + phase) + 0.5 * np.cos(2 * np.pi * 40.3 * turns) + noise
        found = spectral_lines(Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=values), "torque")
        frequency, amplitude = found.measurements
        if periods < 2.5:  # else it is a line of its own
            assert "slower than 3 periods" in frequency.reason
            assert math.isnan(amplitude.value)
        assert frequency.value != pytest.approx(40.3 * RATE_HZ / 4000.0, rel=0.01)


def test_a_steady_drift_is_no_slow_line() -> None:
    turns = np.arange(4000) / 4000.0
    values = 3.0 * turns + 0.5 * np.cos(2 * np.pi * 40.3 * turns)
    found = spectral_lines(Block.from_arrays(RATE_HZ, {"torque": "Nm"}, torque=values), "torque")
    assert found.measurements[0].value == pytest.approx(40.3 * RATE_HZ / 4000.0, rel=1e-3)
