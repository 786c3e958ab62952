"""Symmetrical components against currents that were put together from them."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st

from benchtool.analysis import current_unbalance, track_angle, track_tone
from benchtool.analysis.spectra.unbalance import _Component
from benchtool.analysis.uncertainty import Contribution
from benchtool.block import Block

RATE_HZ, COUNT = 10_000.0, 6_000
A = np.exp(2j * np.pi / 3)


def three_phases(
    positive: complex,
    negative: complex,
    zero: complex,
    noise: float = 0.0,
    seed: int = 0,
    common: float = 0.0,
) -> Block:
    """Currents with these sequence phasors at 43.7 Hz, a fifth harmonic, and noise."""
    theta = 2 * np.pi * 43.7 * np.arange(COUNT) / RATE_HZ
    random = np.random.default_rng(seed)
    shared = common * random.standard_normal(COUNT)
    columns = {}
    for name, turn in (("i_a", 1.0), ("i_b", A**2), ("i_c", A)):
        phasor = positive * turn + negative * np.conj(turn) + zero
        wave = np.real(phasor * np.exp(1j * theta)) + 0.02 * np.cos(5 * theta + np.angle(turn))
        columns[name] = wave + noise * random.standard_normal(COUNT) + shared
    return Block.from_arrays(RATE_HZ, dict.fromkeys(columns, "A"), **columns)


def measured(block: Block) -> dict[str, float]:
    track = track_tone(np.ascontiguousarray(block.column("i_a")), "i_a")
    return {each.name: each.value for each in current_unbalance(block, track)}


phase = st.floats(-3.1, 3.1)


@given(negative=st.floats(0.0, 0.4), zero=st.floats(0.0, 0.3), turns=st.tuples(phase, phase, phase))
@settings(max_examples=20, deadline=None)
def test_components_are_found_again(negative: float, zero: float, turns: tuple[float, float, float]) -> None:
    phasors = [size * np.exp(1j * turn) for size, turn in zip((1.0, negative, zero), turns, strict=True)]
    found = measured(three_phases(*[4.0 * each for each in phasors]))
    assert found["current_sequence_positive"] == pytest.approx(4.0, rel=1e-4)
    assert found["current_sequence_negative"] == pytest.approx(4.0 * negative, abs=4e-4)
    assert found["current_sequence_zero"] == pytest.approx(4.0 * zero, abs=4e-4)
    assert found["current_unbalance_percent"] == pytest.approx(100.0 * negative, abs=1e-2)
    assert found["current_unbalance_zero_percent"] == pytest.approx(100.0 * zero, abs=1e-2)


def test_the_direction_of_rotation_is_no_unbalance() -> None:
    forwards, backwards = three_phases(4.0, 0.2, 0.0), three_phases(0.2, 4.0, 0.0)
    assert measured(backwards)["current_unbalance_percent"] == pytest.approx(
        measured(forwards)["current_unbalance_percent"], rel=1e-3
    )


def test_one_phase_of_another_gain_is_the_textbook_s_unbalance() -> None:
    """Magnitudes 1 + 2 e, 1, 1: I_1 = 1 + 2 e / 3, I_2 = I_0 = 2 e / 3."""
    block = three_phases(1.0, 0.0, 0.0)
    e = 0.03
    data = block.data.copy()
    data[:, 0] *= 1.0 + 2.0 * e
    found = measured(Block(block.channels, 0, 1, block.tick_s, data))
    assert found["current_unbalance_percent"] == pytest.approx(100 * (2 * e / 3) / (1 + 2 * e / 3), rel=1e-3)


@pytest.mark.slow
@pytest.mark.parametrize("common", [0.0, 0.05])
@pytest.mark.parametrize("negative", [0.0, 0.004, 0.1])
def test_the_stated_interval_holds_the_truth(negative: float, common: float) -> None:
    within = 0
    for seed in range(40):
        block = three_phases(2.0, 2.0 * negative, 0.01, noise=0.05, seed=seed, common=common)
        track = track_tone(np.ascontiguousarray(block.column("i_a")), "i_a")
        number = {each.name: each for each in current_unbalance(block, track)}["current_unbalance_percent"]
        assert number.uncertainty is not None
        within += abs(number.value - 100.0 * negative) <= number.uncertainty.expanded
    assert within >= 34


def test_a_clipped_phase_gives_no_unbalance() -> None:
    block = three_phases(2.0, 0.0, 0.0, noise=0.01)
    data = block.data.copy()
    data[:, 2] = np.clip(data[:, 2], -1.5, 1.5)
    clipped = Block(block.channels, 0, 1, block.tick_s, data)
    track = track_tone(np.ascontiguousarray(clipped.column("i_a")), "i_a")
    found = {each.name: each for each in current_unbalance(clipped, track)}
    assert np.isnan(found["current_unbalance_percent"].value)
    assert "clipped" in found["current_unbalance_percent"].reason


def test_without_a_fundamental_there_is_no_ratio() -> None:
    random = np.random.default_rng(3)
    columns = {name: random.standard_normal(COUNT) for name in ("i_a", "i_b", "i_c")}
    block = Block.from_arrays(RATE_HZ, dict.fromkeys(columns, "A"), **columns)
    theta = 2 * np.pi * 43.7 * np.arange(COUNT) / RATE_HZ
    found = {each.name: each for each in current_unbalance(block, track_tone(np.cos(theta), "i_a"))}
    assert "does not stand out" in found["current_unbalance_percent"].reason


def test_steps_of_converters_that_repeat_are_uncertain() -> None:
    block = three_phases(4.0, 0.1, 0.0, noise=1e-3)
    step = 8.0 / 64
    coarse = Block(block.channels, 0, 1, block.tick_s, np.round(block.data / step) * step)
    track = track_tone(np.ascontiguousarray(block.column("i_a")), "i_a")
    fine, found = (
        {each.name: each.uncertainty.standard for each in current_unbalance(one, track) if each.uncertainty}
        for one in (block, coarse)
    )
    for name in ("current_sequence_positive", "current_sequence_negative", "current_sequence_zero"):
        assert found[name] > 5.0 * fine[name]
        assert 1e-3 * step < found[name] < 0.1 * step


def test_lines_that_steps_make_where_several_periods_hold_whole_rows_move_nothing() -> None:
    """Of 500 rows in three periods digits make lines at thirds of orders: no tones of the signal."""
    random, digit = np.random.default_rng(8), 1e-4
    relative = []
    for _ in range(10):
        theta = 2 * np.pi * 3 / 500 * np.arange(6_000) + random.uniform(0, 2 * np.pi)
        size = 5.0 * random.uniform(0.9, 1.1)
        columns = {
            name: digit * np.round(size * np.cos(theta - turn) / digit)
            for name, turn in (("i_a", 0.0), ("i_b", 2 * np.pi / 3), ("i_c", -2 * np.pi / 3))
        }
        block = Block.from_arrays(RATE_HZ, dict.fromkeys(columns, "A"), **columns)
        found = {each.name: each for each in current_unbalance(block, track_tone(columns["i_a"], "i_a"))}
        zero = found["current_sequence_zero"]
        assert zero.uncertainty is not None
        relative.append(zero.value / zero.uncertainty.standard)
    assert 0.5 < float(np.sqrt(np.mean(np.square(relative)))) < 1.6


def test_a_phase_that_wanders_from_period_to_period_moves_no_magnitude() -> None:
    """Five periods of a drive, on the track of an angle that is even."""
    random, per_period = np.random.default_rng(5), 400
    theta = 2 * np.pi * np.arange(5 * per_period + 50) / per_period
    errors = []
    for _ in range(30):
        within = np.repeat(0.003 * random.standard_normal(6), per_period)[: len(theta)]
        columns = {
            name: 2.0 * np.cos(theta + within - turn) + 2e-2 * random.standard_normal(len(theta))
            for name, turn in (("i_a", 0.0), ("i_b", 2 * np.pi / 3), ("i_c", -2 * np.pi / 3))
        }
        block = Block.from_arrays(RATE_HZ, dict.fromkeys(columns, "A"), **columns)
        found = current_unbalance(block, track_angle(theta, 1))[0]
        assert found.uncertainty is not None
        errors.append((found.value - 2.0, found.uncertainty.standard))
    error, stated = np.transpose(errors)
    assert np.median(stated) < 1e-3
    assert 0.4 < float(np.sqrt(np.mean((error / stated) ** 2))) < 1.4


def test_noise_that_a_control_keeps_away_from_the_fundamental_is_not_in_a_mean_of_periods() -> None:
    """Of differences of white noise the mean over a record is that of both ends alone."""
    random, per_period, periods = np.random.default_rng(12), 200, 20
    theta = 2 * np.pi * np.arange(per_period * periods + 3) / per_period
    relative = []
    for _ in range(40):
        space = random.standard_normal(len(theta) + 1) + 1j * random.standard_normal(len(theta) + 1)
        current = (5.0 + 0.3 * np.diff(space)) * np.exp(1j * theta)
        phases = {
            name: np.real(current * np.exp(-2j * np.pi * k / 3))
            for k, name in enumerate(("i_a", "i_b", "i_c"))
        }
        block = Block.from_arrays(10e3, dict.fromkeys(phases, "A"), **phases)
        track = track_angle(np.mod(theta, 2 * np.pi), 1)
        found = {each.name: each for each in current_unbalance(block, track)}["current_sequence_positive"]
        assert found.uncertainty is not None
        relative.append((found.value - 5.0) / found.uncertainty.standard)
    assert 0.3 < np.sqrt(np.mean(np.square(relative))) < 1.3  # 0.2 by the scatter over periods


def test_a_swing_of_all_three_moves_no_component() -> None:
    random = np.random.default_rng(13)
    theta = 2 * np.pi * np.arange(200 * 50 + 3) / 200
    swing = 1.0 + 0.04 * np.cos(3.3 * theta / 50 + 1.0)
    phases = {
        name: 5.0 * swing * np.cos(theta - 2 * np.pi * k / 3) + 0.01 * random.standard_normal(len(theta))
        for k, name in enumerate(("i_a", "i_b", "i_c"))
    }
    block = Block.from_arrays(10e3, dict.fromkeys(phases, "A"), **phases)
    track = track_angle(np.mod(theta, 2 * np.pi), 1)
    found = {each.name: each for each in current_unbalance(block, track)}["current_sequence_positive"]
    assert found.uncertainty is not None
    assert found.uncertainty.standard < 1e-3  # of a swing of 0.2 A
    assert abs(found.value - 5.0) < 3.0 * found.uncertainty.standard


def test_few_periods_of_noise_state_what_they_scatter() -> None:
    """Bins beside the fundamental tell the noise of six periods better than their scatter does."""
    relative = []
    for seed in range(50):
        random = np.random.default_rng([21, seed])
        theta = 2 * np.pi * np.arange(200 * 6 + 70) / 200 + random.uniform(0, 2 * np.pi)
        phases = {
            name: 5.0 * np.cos(theta - turn) + 0.05 * random.standard_normal(len(theta))
            for name, turn in (("i_a", 0.0), ("i_b", 2 * np.pi / 3), ("i_c", -2 * np.pi / 3))
        }
        block = Block.from_arrays(10e3, dict.fromkeys(phases, "A"), **phases)
        positive = current_unbalance(block, track_angle(np.mod(theta, 2 * np.pi), 1))[0]
        assert positive.uncertainty is not None
        relative.append((positive.value - 5.0) / positive.uncertainty.standard)
    assert 0.7 < np.sqrt(np.mean(np.square(relative))) < 1.3  # 0.5 by the scatter over periods


@pytest.mark.parametrize("seed", [77, 141, 188])
def test_a_small_sequence_whose_few_periods_look_alike_is_known_as_one_of_them(seed: int) -> None:
    """Noise along a negative sequence may be more than across it, by chance, and neighbours alike."""
    whole = three_phases(0.643, 1e-4, 0.0, 0.01, seed)
    block = Block(whole.channels, 0, 1, whole.tick_s, whole.data[:1200])
    track = track_tone(np.ascontiguousarray(block.column("i_a")), "i_a")
    found = {each.name: each for each in current_unbalance(block, track)}
    for name, truth in (("current_sequence_negative", 1e-4), ("current_unbalance_percent", 1e-2 / 0.643)):
        uncertain = found[name].uncertainty
        assert uncertain is not None
        assert abs(found[name].value - truth) < uncertain.expanded
        assert uncertain.expanded < 100.0 * truth


def test_a_tone_between_the_harmonics_is_not_in_a_component() -> None:
    random = np.random.default_rng(22)
    theta = 2 * np.pi * np.arange(200 * 8 + 70) / 200
    phases = {
        name: 5.0 * np.cos(theta - turn)
        + 0.05 * np.cos(1.37 * theta - turn + 0.4)
        + 2e-3 * random.standard_normal(len(theta))
        for name, turn in (("i_a", 0.0), ("i_b", 2 * np.pi / 3), ("i_c", -2 * np.pi / 3))
    }
    block = Block.from_arrays(10e3, dict.fromkeys(phases, "A"), **phases)
    positive = current_unbalance(block, track_angle(np.mod(theta, 2 * np.pi), 1))[0]
    assert positive.uncertainty is not None
    assert positive.uncertainty.standard < 2e-4  # 6e-3 with the tone in it
    assert positive.value == pytest.approx(5.0, abs=2.5 * positive.uncertainty.standard)


def test_currents_with_next_to_no_noise_are_as_uncertain_as_their_resampling() -> None:
    random, errors = np.random.default_rng(1), []
    for per_period in (11.9, 13.1, 34.0, 60.6, 241.9):
        theta = np.asarray(2 * np.pi * np.arange(int(30.4 * per_period) + 64.0) / per_period, np.float64)
        phases = {
            name: 3.0 * np.cos(theta + 0.4 - 2 * np.pi * k / 3) + 1e-8 * random.standard_normal(len(theta))
            for k, name in enumerate(("i_a", "i_b", "i_c"))
        }
        block = Block.from_arrays(RATE_HZ, dict.fromkeys(phases, "A"), **phases)
        found = current_unbalance(block, track_angle(theta, 1))[0]
        assert found.uncertainty is not None
        errors.append(abs(found.value - 3.0) / found.uncertainty.standard)
    assert max(errors) < 2.0  # 10 to 200 by the noise alone


@pytest.mark.parametrize("swing", [0.0, 0.03])
def test_a_load_that_falls_makes_no_negative_sequence(swing: float) -> None:
    """Of one that falls by 5 % over 54 periods 4e-4 A were left, with half of that as its error, or more."""
    count, random = 30_000, np.random.default_rng(2)
    place = np.linspace(-0.5, 0.5, count)
    theta = np.asarray(2 * np.pi * 18.0 * np.arange(count) / RATE_HZ, dtype=np.float64)
    load = 5.0 * (1.0 - 0.05 * place + swing * np.cos(2 * np.pi * 8.7 * place + 1.0))
    columns = {
        f"i_{phase}": load * np.cos(theta - 2 * np.pi / 3 * k) + 1e-3 * random.standard_normal(count)
        for k, phase in enumerate("abc")
    }
    block = Block.from_arrays(RATE_HZ, dict.fromkeys(columns, "A"), **columns)
    numbers = {each.name: each for each in current_unbalance(block, track_angle(theta, 1))}
    found = numbers["current_sequence_negative"]
    assert found.uncertainty is not None
    assert abs(found.value) < 2.0 * found.uncertainty.expanded
    assert found.uncertainty.expanded < 1.5e-4


@pytest.mark.parametrize(
    ("periods", "swing", "drift"), [(20.3, 0.0, 0.0), (54.4, 0.03, 0.0), (54.3, 0.0, 0.04)]
)
def test_the_course_of_a_load_is_no_noise_of_its_positive_sequence(
    periods: float, swing: float, drift: float
) -> None:
    """A line through the amplitudes and one swing about it: as noise of them it was 0.1 to 0.2 A of 5 A."""
    count, random, errors = 12_000, np.random.default_rng(3), []
    place = (np.arange(count) + 0.5) / count - 0.5
    for _ in range(8):
        theta = 2 * np.pi * (periods * (place + 0.5 * drift * place**2) + random.uniform())
        swung = np.cos(2 * np.pi * (3.0 * place + random.uniform()))
        load = 5.0 * (1.0 - 0.05 * place + swing * swung)
        columns = {
            f"i_{phase}": load * np.cos(theta - 2 * np.pi / 3 * k) + 1e-3 * random.standard_normal(count)
            for k, phase in enumerate("abc")
        }
        block = Block.from_arrays(RATE_HZ, dict.fromkeys(columns, "A"), **columns)
        found = current_unbalance(block, track_angle(theta, 1))[0]
        assert found.name == "current_sequence_positive"
        assert found.uncertainty is not None
        assert found.uncertainty.standard < 1e-4
        errors.append((found.value - 5.0) / found.uncertainty.standard)
    assert float(np.sqrt(np.mean(np.square(errors)))) < 1.7


@pytest.mark.parametrize(
    ("standard", "scatter", "is_known"),
    [
        (0.1, 9.0, True),
        (0.3, 0.1, False),
        (math.nan, 0.5, True),
        (math.nan, 2.0, False),
    ],
)
def test_a_sequence_is_a_reference_if_it_stands_out_of_its_noise_or_else_of_its_scatter(
    standard: float, scatter: float, is_known: bool
) -> None:
    """Of a current without load, which wanders more slowly than the record shows, the noise is not known."""
    component = _Component(1.0, 1.0, (Contribution("noise along the phasor", "A", standard),), scatter)
    assert component.stands_out is is_known
