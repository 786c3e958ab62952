"""Groups after IEC 61000-4-7 against its sums written out bin by bin, and against known signals."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.typing import NDArray
from scipy import signal

from benchtool.analysis import (
    CoherentSamples,
    HarmonicGroups,
    coherent_samples,
    group_distortion,
    group_table,
    harmonic_groups,
    track_angle,
)
from benchtool.analysis.measurement import Basis
from benchtool.analysis.spectra.groups import (
    Kind,
    power_beside_lines,
    scatter_of_begins,
    scatter_of_bursts,
)
from benchtool.analysis.statistics.scatter import MeanError

RATE_HZ = 10e3
Array = NDArray[np.float64]


def samples_of(values: Array, periods: int) -> CoherentSamples:
    return CoherentSamples(values, periods, float(len(values)), RATE_HZ)


def groups_of(values: Array, periods: int, highest: int = 50) -> HarmonicGroups:
    groups = harmonic_groups(samples_of(values, periods), highest)
    assert groups is not None
    return groups


def by_hand(window: Array, periods: int, orders: int) -> tuple[list[float], list[float], list[float]]:
    """Squares of group, subgroup and interharmonic centred subgroup, one bin after the other."""
    number = np.arange(len(window))

    def square(bin_: int) -> float:
        phasor = np.sum(window * np.exp(-2j * np.pi * bin_ * number / len(window)))
        return float(2.0 * abs(phasor / len(window)) ** 2)

    group, subgroup, between = [], [], []
    for order in range(1, orders + 1):
        center, half = order * periods, periods / 2
        total = 0.0
        for bin_ in range(center - periods, center + periods + 1):
            distance = abs(bin_ - center)
            total += square(bin_) * (1.0 if distance < half else 0.5 if distance == half else 0.0)
        group.append(total)
        subgroup.append(sum(square(center + k) for k in (-1, 0, 1)))
        between.append(sum(square(center + k) for k in range(2, periods - 1)))
    return group, subgroup, between


@settings(max_examples=20, deadline=None)
@given(st.integers(4, 23), st.integers(0, 2**31))
def test_groups_are_the_sums_of_the_standard(periods: int, seed: int) -> None:
    values = np.random.default_rng(seed).normal(size=periods * 16)

    groups = groups_of(values, periods)

    size = min(periods, 10)
    assert groups.periods_per_window == size
    assert groups.windows == periods // size
    assert groups.orders == 6  # 0.45 x 16 = 7.2, of which the interharmonics of the last order need one
    for window in range(groups.windows):
        part = values[window * size * 16 : (window + 1) * size * 16]
        expected = by_hand(part, size, groups.orders)
        for found, sums in zip(
            (groups.group2, groups.subgroup2, groups.interharmonic2), expected, strict=True
        ):
            np.testing.assert_allclose(found[window], sums, rtol=1e-9, atol=1e-12)


def test_a_tone_is_in_the_group_its_frequency_belongs_to() -> None:
    turns = np.arange(40 * 200) / 200  # fundamental periods

    def at(order: float) -> HarmonicGroups:
        return groups_of(0.1 * np.cos(2 * np.pi * order * turns + 0.3), 40)

    square = 0.1**2 / 2
    exact, beside, between, halfway = at(5.0), at(5.1), at(5.3), at(5.5)
    assert exact.group2[:, 4] == pytest.approx(square)
    assert exact.subgroup2[:, 4] == pytest.approx(square)
    assert exact.interharmonic2[:, 4] == pytest.approx(0.0, abs=1e-12)
    assert beside.subgroup2[:, 4] == pytest.approx(square)
    assert between.subgroup2[:, 4] == pytest.approx(0.0, abs=1e-12)
    assert between.interharmonic2[:, 4] == pytest.approx(square)
    assert between.group2[:, 4] == pytest.approx(square)
    assert halfway.group2[:, 4] == pytest.approx(square / 2)
    assert halfway.group2[:, 5] == pytest.approx(square / 2)


@settings(max_examples=20, deadline=None)
@given(st.integers(4, 12), st.integers(0, 2**31))
def test_groups_keep_the_power_between_half_the_first_and_half_past_the_last_order(
    periods: int, seed: int
) -> None:
    values = np.random.default_rng(seed).normal(size=periods * 32)

    groups = groups_of(values, periods)

    size = groups.periods_per_window * 32
    bins = 2.0 * np.abs(np.fft.rfft(values[:size]) / size) ** 2
    order = np.arange(len(bins)) / groups.periods_per_window
    weight = np.where((order > 0.5) & (order < groups.orders + 0.5), 1.0, 0.0)
    weight[(order == 0.5) | (order == groups.orders + 0.5)] = 0.5
    assert np.sum(groups.group2[0]) == pytest.approx(float(weight @ bins))


def test_group_distortions_of_a_modulated_harmonic() -> None:
    turns = np.arange(100 * 200) / 200
    fifth = 0.1 * (1.0 + 0.5 * np.cos(2 * np.pi * 0.1 * turns)) * np.cos(2 * np.pi * 5 * turns)

    groups = groups_of(np.cos(2 * np.pi * turns) + fifth, 100)

    # sidebands of a quarter each, one bin to either side: in the subgroup, where a harmonic alone has none
    expected = 0.1 * math.sqrt(1 + 2 * 0.25**2)
    assert group_distortion(groups, "subgroup").ratio == pytest.approx(expected)
    assert group_distortion(groups, "group").ratio == pytest.approx(expected)
    assert group_distortion(groups, "group").standard == pytest.approx(0.0, abs=1e-9)


def test_the_uncertainty_is_the_scatter_over_the_windows() -> None:
    generator = np.random.default_rng(6)
    turns = np.arange(100 * 200) / 200
    found = []
    for _ in range(60):
        size = np.repeat(generator.normal(0.1, 0.02, 10), 10 * 200)
        found.append(
            group_distortion(
                groups_of(np.cos(2 * np.pi * turns) + size * np.cos(10 * np.pi * turns), 100), "group"
            )
        )

    # of ten windows each: the standard uncertainty is Student's, and a little more than the scatter
    values, stated = (
        np.array(each) for each in zip(*((one.ratio, one.standard) for one in found), strict=True)
    )
    assert 0.7 < np.sqrt(np.mean(((values - np.mean(values)) / stated) ** 2)) < 1.2


def test_the_noise_in_the_groups_of_one_window_scatters_by_its_power() -> None:
    """Five periods, whose noise is far more than the only harmonic, and larger at low orders."""
    from scipy.signal import lfilter

    generator, ratios, stated = np.random.default_rng(8), [], []
    wave = np.cos(2 * np.pi * np.arange(5 * 200) / 200)
    for _ in range(60):
        noise = 0.01 * lfilter([1.0], [1.0, -0.8], generator.standard_normal(1200))[200:]
        groups = groups_of(wave + noise, 5)
        ratios.append(group_distortion(groups, "group").ratio)
        stated.append(power_beside_lines(groups, "group").standard)
    assert 0.8 < np.std(ratios) / np.sqrt(np.mean(np.square(stated))) < 1.3


@pytest.mark.parametrize("kind", ["group", "subgroup"])
def test_what_lies_beside_a_line_is_gone_in_the_mean_over_windows(kind: Kind) -> None:
    """Sidebands of the fifth, two cycles over all windows, whose phase is random: only their power, which
    is the same in all records, is in the distortion."""
    generator, found = np.random.default_rng(9), []
    turns = np.arange(60 * 200) / 200
    for _ in range(20):
        slow = 0.05 * np.cos(2 * np.pi * (turns / 30 + generator.uniform()))
        wave = np.cos(2 * np.pi * turns) + (0.1 + slow) * np.cos(10 * np.pi * turns)
        found.append(group_distortion(groups_of(wave, 60), kind, MeanError(0.0, math.inf), 0.0, 0.1))
    ratio, stated = (np.array([getattr(each, name) for each in found]) for name in ("ratio", "standard"))
    assert np.ptp(ratio) < 1e-3 * np.mean(ratio)
    assert np.max(stated) < 0.03 * np.mean(ratio)


def test_the_power_of_noise_in_the_windows_is_known_as_well_as_it_is_repeated() -> None:
    """Bursts: of noise in one window of six by chance, whose power is far more than that of the others."""
    generator, ratios, stated = np.random.default_rng(10), [], []
    wave = np.cos(2 * np.pi * np.arange(60 * 200) / 200)
    for _ in range(80):
        loud = np.repeat(np.where(generator.uniform(size=6) < 0.4, 0.3, 0.03), 2000)
        groups = groups_of(wave + loud * generator.standard_normal(12000), 60)
        ratios.append(group_distortion(groups, "group").ratio ** 2)
        stated.append(2.0 * math.sqrt(ratios[-1]) * power_beside_lines(groups, "group").standard)
    assert 0.6 < np.std(ratios) / np.sqrt(np.mean(np.square(stated))) < 1.3


@pytest.mark.parametrize("kind", ["group", "subgroup"])
def test_noise_in_three_windows_is_known_by_its_many_bins(kind: Kind) -> None:
    """The scatter of three values is hardly known, and by chance often a third of what it is, or thrice."""
    generator, ratios, stated = np.random.default_rng(12), [], []
    wave = np.cos(2 * np.pi * np.arange(30 * 100) / 100)
    for _ in range(100):
        groups = groups_of(wave + 0.01 * generator.standard_normal(3000), 30, 40)
        ratios.append(group_distortion(groups, kind).ratio)
        stated.append(power_beside_lines(groups, kind).standard)
    assert 0.8 < np.std(ratios) / np.median(stated) < 1.3


def test_fewer_than_four_periods_or_no_harmonic_give_no_groups() -> None:
    assert harmonic_groups(samples_of(np.ones(3 * 200), 3), 50) is None
    assert harmonic_groups(samples_of(np.ones(20 * 4), 20), 50) is None


def test_one_order_alone_has_no_distortion() -> None:
    groups = groups_of(np.cos(2 * np.pi * np.arange(20 * 5) / 5), 20)

    assert groups.orders == 1
    assert math.isnan(group_distortion(groups, "group").ratio)


def test_from_samples_at_a_fixed_rate_the_groups_are_in_step_with_the_rotor() -> None:
    theta_e = 2 * np.pi * 37.3 * np.arange(8000, dtype=np.float64) / RATE_HZ
    samples = np.cos(theta_e) + 0.05 * np.cos(7 * theta_e)

    groups = harmonic_groups(coherent_samples(samples, RATE_HZ, track_angle(theta_e, 1)), 20)

    assert groups is not None
    assert (groups.windows, groups.periods_per_window, groups.orders) == (2, 10, 20)
    assert group_distortion(groups, "subgroup").ratio == pytest.approx(0.05, rel=1e-3)
    table = group_table(groups, "current_groups", "A", Basis())
    assert table.rows[6][:3] == pytest.approx((7, 0.05 / math.sqrt(2), 0.05 / math.sqrt(2)), rel=1e-3)
    assert table.rows[6][3] < 1e-4


def test_where_windows_begin_matters_where_the_current_is_another_at_both_ends() -> None:
    turns = np.arange(41 * 200) / 200
    wave = np.cos(2 * np.pi * turns) + 0.05 * np.cos(10 * np.pi * turns)
    swinging = 1.0 + 0.06 * np.cos(2 * np.pi * 0.064 * turns)

    steady = scatter_of_begins(samples_of(wave, 41), 50)
    moving = scatter_of_begins(samples_of(swinging * wave, 41), 50)

    assert steady["group"] < 1e-12
    ratios = []
    for begin in range(0, 200, 10):
        groups = groups_of((swinging * wave)[begin : begin + 40 * 200], 40)
        ratios.append(group_distortion(groups, "group").ratio)
    assert moving["group"] == pytest.approx(np.std(ratios), rel=0.1)
    assert scatter_of_begins(samples_of(wave[:2000], 10), 50) == {"group": 0.0, "subgroup": 0.0}


def test_in_which_period_windows_begin_matters_where_a_line_is_beside_a_harmonic() -> None:
    """Against the fifth it turns by less than a quarter within a period, and by all within five."""
    turns = np.arange(45 * 200) / 200
    wave = np.cos(2 * np.pi * turns) + 0.05 * np.cos(10 * np.pi * turns)
    ratios, told = [], []
    for phase in np.linspace(0.0, 2 * np.pi, 12, endpoint=False):
        line = 0.01 * np.cos(2 * np.pi * 4.79 * turns + phase)
        ratios.append(group_distortion(groups_of(wave[:8000] + line[:8000], 40), "group").ratio)
        told.append(scatter_of_begins(samples_of(wave + line, 45), 50)["group"])
    assert np.min(told) > 0.5 * np.std(ratios)
    assert np.mean(told) == pytest.approx(np.std(ratios), rel=0.3)


def test_few_clicks_make_groups_of_few_windows_as_uncertain_as_their_number_is() -> None:
    """Eight clicks on average in two windows: in every bin alike, so that none of these tells the others'."""
    turns, random = np.arange(20 * 200) / 200, np.random.default_rng(9)
    wave = np.cos(2 * np.pi * turns) + 0.03 * np.cos(10 * np.pi * turns)
    ratios, with_bursts, of_bins = [], [], []
    for _ in range(40):
        clicks = 0.5 * random.choice([-1.0, 1.0], len(turns)) * (random.random(len(turns)) < 8 / len(turns))
        samples = samples_of(wave + clicks, 20)
        groups, bursts = harmonic_groups(samples, 50), scatter_of_bursts(samples)
        assert groups is not None
        assert bursts == pytest.approx(np.count_nonzero(clicks) ** -0.5, rel=0.2)
        ratios.append(group_distortion(groups, "group").ratio)
        with_bursts.append(power_beside_lines(groups, "group", bursts).standard)
        of_bins.append(power_beside_lines(groups, "group").standard)
    assert np.mean(of_bins) < 0.3 * np.std(ratios)
    assert np.mean(with_bursts) == pytest.approx(np.std(ratios), rel=0.3)


@pytest.mark.parametrize("pole", [0.0, 0.9])
def test_normal_noise_of_any_colour_has_no_bursts(pole: float) -> None:
    random = np.random.default_rng(11)
    for _ in range(10):
        noise = signal.lfilter([1.0], [1.0, -pole], random.standard_normal(5000))[-4000:]
        assert scatter_of_bursts(samples_of(np.cos(np.pi * np.arange(4000) / 100) + noise, 20)) == 0.0
