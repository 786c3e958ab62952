"""Crests that are level: those of a current that was clipped before noise came in, and no round ones."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.analysis import (
    current_spectrum,
    current_unbalance,
    order_analysis,
    signal_remarks,
    track_angle,
)
from benchtool.analysis.spectra.flat_crests import _folded, _level_share, _longest, _slope, flat_crest
from benchtool.block import Block

Floats = NDArray[np.float64]
Wave = Callable[[Floats], Floats]

RATE_HZ, POLE_PAIRS, COUNT = 10_000.0, 4, 20_000


def harmonics(theta: Floats) -> Floats:
    return np.asarray(np.cos(theta) + 0.03 * np.cos(5 * theta + 1.0) + 0.02 * np.cos(7 * theta + 2.0))


def angle(random: np.random.Generator, periods: float = 40.3, count: int = COUNT) -> Floats:
    return np.asarray(2 * np.pi * (np.arange(count) / count * periods + random.uniform()))


def found(wave: Wave, noise: float, *, clip: float = math.inf, step: float = 0.0, seed: int = 0) -> float:
    random = np.random.default_rng(seed)
    theta = angle(random)
    read = np.clip(wave(theta), -clip, clip) + noise * random.standard_normal(COUNT)
    if step:
        read = step * np.round((read - random.uniform() * step) / step)
    return flat_crest(read, theta / (2 * np.pi), step)


@pytest.mark.parametrize(
    ("clip", "noise"), [(0.98, 1e-4), (0.95, 1e-3), (0.93, 1e-2), (0.8, 3e-3), (0.5, 1e-2)]
)
def test_a_crest_that_is_clipped_before_the_noise_is_level(clip: float, noise: float) -> None:
    theta = np.linspace(0.0, 2 * np.pi, 100_001)
    share = max(np.mean(harmonics(theta) > clip), np.mean(harmonics(theta) < -clip))
    for seed in range(5):
        assert found(harmonics, noise, clip=clip, seed=seed) == pytest.approx(share, abs=0.011)


@pytest.mark.parametrize("sign", [1.0, -1.0])
def test_one_crest_that_is_level_is_enough(sign: float) -> None:
    def one_sided(theta: Floats) -> Floats:
        return np.asarray(sign * np.minimum(np.cos(theta), 0.8))

    assert found(one_sided, 1e-3) == pytest.approx(math.acos(0.8) / math.pi, abs=0.011)


def test_a_crest_that_goes_on_falling_slowly_to_one_side_has_no_corner_there() -> None:
    def creeping(theta: Floats) -> Floats:
        place = np.mod(theta / (2 * np.pi), 1.0)
        return np.asarray(np.where(place < 0.5, 1.0 - 4e-3 * (place / 0.2) ** 2, 0.0))

    assert found(creeping, 1e-3) == 0.0


@pytest.mark.parametrize("rows", [62.5, 125.0, 200.0, 200.0003, 240.0, 400.0])
@pytest.mark.parametrize("clip", [0.8, 0.9, math.inf])
def test_a_period_of_a_whole_number_of_rows(rows: float, clip: float) -> None:
    random = np.random.default_rng(5)
    theta = angle(random, COUNT / rows)
    read = np.clip(np.cos(theta), -clip, clip) + 1e-3 * random.standard_normal(COUNT)
    share = math.acos(min(clip, 1.0)) / math.pi
    assert flat_crest(read, theta / (2 * np.pi)) == pytest.approx(share, abs=0.03)


def test_a_crest_that_is_level_on_both_sides_of_a_dip() -> None:
    def wave(theta: Floats) -> Floats:
        humps = (0.05, 5, 2.8), (0.03, 7, 5.6), (0.03, 11, 1.0)
        return np.asarray(np.cos(theta) + sum(size * np.cos(k * theta + by) for size, k, by in humps))

    crest = float(np.max(wave(np.linspace(0.0, 2 * np.pi, 10_000))))
    for seed in range(4):
        assert found(wave, 1e-4, clip=0.9 * crest, seed=seed) == pytest.approx(0.14, abs=0.01)


@pytest.mark.parametrize("noise", [0.0, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1])
@pytest.mark.parametrize(
    "wave",
    [
        np.cos,
        harmonics,
        lambda theta: np.cos(theta) - np.cos(3 * theta) / 9,  # as flat as a third harmonic makes it
        lambda theta: np.cos(theta) - np.cos(3 * theta) / 6,
        lambda theta: np.cos(theta) + 0.2 * np.cos(5 * theta) + 0.12 * np.cos(7 * theta),
    ],
)
def test_a_round_crest_is_not_level_however_flat_it_is(wave: Wave, noise: float) -> None:
    assert [found(wave, noise, seed=seed) for seed in range(4)] == [0.0] * 4


@pytest.mark.parametrize("bits", [5, 6, 7, 8, 10])
def test_the_highest_level_of_a_converter_is_no_level_crest(bits: int) -> None:
    for noise in (1e-5, 2e-3):
        assert found(harmonics, noise, step=2.2 / 2**bits) == 0.0


def test_few_periods_and_an_amplitude_that_ramps() -> None:
    random = np.random.default_rng(3)
    theta = angle(random, 4.3, 2_000)
    short = np.clip(harmonics(theta), -0.9, 0.9) + 1e-3 * random.standard_normal(2_000)
    assert flat_crest(short, theta / (2 * np.pi)) > 0.1
    assert flat_crest(short[:800], theta[:800] / (2 * np.pi)) == 0.0  # fewer than three periods
    theta = angle(random)
    ramp = np.linspace(0.95, 1.05, COUNT) * harmonics(theta) + 1e-3 * random.standard_normal(COUNT)
    assert flat_crest(ramp, theta / (2 * np.pi)) == 0.0


@pytest.mark.parametrize("clip", [0.93, math.inf])
def test_numbers_of_a_clipped_current_have_no_uncertainty_and_a_remark(clip: float) -> None:
    random = np.random.default_rng(4)
    theta = angle(random)
    read = 5.0 * (np.clip(harmonics(theta), -clip, clip) + 2e-3 * random.standard_normal(COUNT))
    block = Block.from_arrays(RATE_HZ, {"i_a": "A"}, i_a=read)
    spectrum = current_spectrum(block, "i_a", track_angle(theta / POLE_PAIRS, POLE_PAIRS))
    numbers = {each.name: each for each in spectrum.measurements}
    remarks = signal_remarks(spectrum.measurements)
    is_clipped = math.isfinite(clip)
    assert len(remarks) == int(is_clipped)
    for name in ("current_fundamental", "current_thd_f", "current_noise_floor"):
        assert (numbers[name].uncertainty is None) == is_clipped
        assert ("clipped before noise" in numbers[name].uncertainty_reason) == is_clipped
    assert numbers["fundamental_frequency"].uncertainty is not None
    assert math.isnan(spectrum.tables[0].rows[0][-1]) == is_clipped
    assert ("clipped" in spectrum.tables[0].uncertainty_reason) == is_clipped


def test_components_and_orders_of_a_clipped_current_have_none_either_and_those_of_a_torque_have() -> None:
    random = np.random.default_rng(5)
    theta = angle(random)
    columns = {
        name: 5.0 * np.clip(harmonics(theta - turn), -0.93, 0.93) + 1e-2 * random.standard_normal(COUNT)
        for name, turn in (("i_a", 0.0), ("i_b", 2 * np.pi / 3), ("i_c", -2 * np.pi / 3))
    }
    theta_m = np.mod(theta / POLE_PAIRS, 2 * np.pi)
    units = {**dict.fromkeys(columns, "A"), "torque": "Nm", "theta_m": "rad"}
    block = Block.from_arrays(RATE_HZ, units, **columns, torque=columns["i_a"], theta_m=theta_m)
    track = track_angle(theta_m, POLE_PAIRS)
    for each in current_unbalance(block, track):
        assert each.uncertainty is None, each.name
        assert "clipped before noise" in each.uncertainty_reason
    of_current, of_torque = (order_analysis(block, name, pole_pairs=POLE_PAIRS) for name in ("i_a", "torque"))
    assert all(each.uncertainty is None for each in of_current.measurements)
    assert "clipped" in of_current.tables[0].uncertainty_reason
    assert any(each.uncertainty is not None for each in of_torque.measurements)


def test_components_take_over_the_crest_of_a_spectrum_that_is_known() -> None:
    theta = angle(np.random.default_rng(6))
    columns = {name: np.cos(theta - turn) for name, turn in (("i_a", 0.0), ("i_b", 2.1), ("i_c", -2.1))}
    block = Block.from_arrays(RATE_HZ, dict.fromkeys(columns, "A"), **columns)
    of_a = current_spectrum(block, "i_a", track_angle(theta / POLE_PAIRS, POLE_PAIRS))
    assert of_a.flat_crest == 0.0
    for share in (0.0, 0.1):
        found = current_unbalance(block, of_a.track, known={"i_a": replace(of_a, flat_crest=share)})
        assert {each.basis.flat_crest for each in found} == {share or None}


def _wave(crest: list[float], places: int = 100) -> Floats:
    """A waveform with these places at its crest, which falls by a tenth a place on either side."""
    beside = 1.0 - 0.1 * np.arange(1.0, 1.0 + (places - len(crest)) / 2)
    return np.concatenate([beside[::-1], crest, beside])[:places]


@pytest.mark.parametrize(("length", "share"), [(6, 0.0), (7, 0.07), (20, 0.2)])
def test_a_level_crest_has_seven_places_or_more(length: int, share: float) -> None:
    assert _level_share(_wave([1.0] * length), np.full(100, 1e-3), 0.0) == pytest.approx(share)


def test_a_crest_is_level_about_its_mean_and_not_its_greatest() -> None:
    """Of a tolerance of 4 errors, 0.9 and 1.5 below the greatest: the mean is 0.79 below it."""
    crest = 1.0 - 4e-3 * np.array([0.0] + 7 * [0.9] + 2 * [1.5])
    assert _level_share(_wave(crest.tolist()), np.full(100, 1e-3), 0.0) == pytest.approx(0.1)


def test_the_tolerance_is_by_the_median_error_within_a_fortieth_of_a_period() -> None:
    """Of 216 places six to either side, and of these 13 seven with the larger error."""
    wave = _wave([1.0 - 7e-3] * 3 + [1.0] * 10 + [1.0 - 7e-3] * 3, 216)
    error = np.full(216, 2e-3)
    top = int(np.argmax(wave))
    error[top - 3 : top + 3] = 1e-3
    assert _level_share(wave, error, 0.0) == pytest.approx(16 / 216)
    error[top + 3] = 1e-3
    assert _level_share(wave, error, 0.0) == 0.0  # of the ten that are level beside lower ones


def test_the_longest_run_is_told_wherever_it_is() -> None:
    assert _longest(np.array([True, True, True, False, True])) == (0, 2)
    assert _longest(np.array([True, False, True, True, True])) == (2, 4)


def test_beside_a_corner_a_waveform_has_the_slope_of_its_flatter_side() -> None:
    wave = np.array([0.0, 1.0, 3.0, 6.0, 6.0, 4.0, 1.0])
    assert _slope(wave).tolist() == [0.0, 1.0, 2.0, 0.0, 0.0, -2.0, -1.0]


def test_six_samples_are_at_a_place_and_their_scatter_is_its_error() -> None:
    random = np.random.default_rng(7)
    turns = np.sort(random.uniform(100.0, 120.0, 2400))
    read = np.cos(2 * np.pi * turns) + 1e-3 * random.standard_normal(2400)
    for count, places in ((600, 100), (2400, 240)):
        even = 0.05 * math.sqrt(1.2) * np.arange(count, dtype=np.float64)
        found = _folded(np.cos(2 * np.pi * even), even)
        assert found is not None
        assert len(found[0]) == places
    assert flat_crest(np.clip(np.cos(2 * np.pi * even), -0.8, 0.8)[:350], even[:350]) == 0.0  # 58 places
    found = _folded(read, turns)
    assert found is not None
    wave, error = found
    middles = np.cos(2 * np.pi * (np.arange(len(wave)) + 0.5) / len(wave))
    assert np.sqrt(np.mean(((wave - middles) / error) ** 2)) < 1.5
    assert np.median(error) == pytest.approx(1e-3 / math.sqrt(2400 / len(wave)), rel=0.2)


@pytest.mark.parametrize(("periods", "is_told"), [(2.95, False), (3.05, True)])
def test_three_periods_from_any_one_on_tell(periods: float, is_told: bool) -> None:
    turns = 100.0 + np.linspace(0.0, periods, 2400)
    read = np.clip(np.cos(2 * np.pi * turns), -0.8, 0.8)
    noise = 1e-3 * np.random.default_rng(8).standard_normal(2400)
    assert (flat_crest(read + noise, turns) > 0.0) is is_told


@pytest.mark.parametrize("greatest", [0.1, 2.3, 4.1, 4.7, 31.7])
def test_a_level_crest_without_noise_is_told_though_its_mean_is_rounded(greatest: float) -> None:
    turns = np.arange(4000) / 97.3
    wave = np.clip(1.25 * greatest * np.cos(2 * np.pi * turns), -greatest, greatest)
    assert flat_crest(wave, turns) == pytest.approx(math.acos(0.8) / math.pi, abs=0.03)
