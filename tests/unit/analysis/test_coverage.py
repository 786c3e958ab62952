"""The short form of `python -m benchmarks.coverage`: a few families, a few records."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy import integrate, signal

from benchmarks.coverage.dynamic import Lag
from benchmarks.coverage.families import Family, scores, selected
from benchmarks.coverage.registry import FAMILIES
from benchmarks.coverage.representative import REPRESENTATIVE
from benchtool.analysis import Measurement, Uncertainty
from tests.at_length import at_length

_SPECTRAL = ("current_fundamental", "current_thd_f", "fundamental_frequency", "harmonic_5", "torque_mean")


@pytest.mark.parametrize(
    "name",
    [
        "swing_0.5Hz_no_angle",
        *at_length("white_-40dB_no_angle", "coloured_no_angle", "interharmonic_no_angle"),
    ],
)
def test_stated_uncertainties_hold_the_truth(name: str) -> None:
    found = {each.measurement: each for each in scores(FAMILIES[name], 6)}
    for measurement in _SPECTRAL:
        assert found[measurement].answered == 6
        assert found[measurement].verdict != "narrow", found[measurement]


@pytest.mark.parametrize(
    "name",
    [
        "reversal",
        "standstill_within_no_angle",
        "clipped",
        "two_regimes_no_angle",
        "standstill_current",
        *at_length("reversal_no_angle"),
    ],
)
def test_what_cannot_be_told_is_null(name: str) -> None:
    found = {each.measurement: each for each in scores(FAMILIES[name], 3)}
    for measurement in ("current_thd_f", "current_thd_f_subgroups"):
        assert measurement not in found or found[measurement].answered == 0
    assert found


@pytest.mark.parametrize(
    "name",
    [
        "flux_few_revolutions",
        "switching_irregular",
        "residual_coloured",
        "unbalance",
        "stamps_gap",
        *at_length("flux_bits_8"),
    ],
)
def test_further_channels_hold_the_truth(name: str) -> None:
    found = list(scores(FAMILIES[name], 12))
    assert found
    for each in found:
        assert each.answered or each.uncompared  # an order that noise brings to the list has no truth
        assert each.verdict != "narrow", each


@pytest.mark.parametrize(
    "name", ["unbalance_reversal", "flux_two_regimes", "flux_reversal", "unbalance_clipped"]
)
def test_no_steady_state_is_null_there_too(name: str) -> None:
    assert all(each.verdict == "null" for each in scores(FAMILIES[name], 3))


def test_an_encoder_s_error_in_few_revolutions_is_in_its_orders() -> None:
    found = {each.measurement: each for each in scores(FAMILIES["wobble_few_revolutions"], 3)}
    assert found["torque_order_24"].within_2u == 1.0


def test_an_amplitude_that_wanders_over_the_whole_record_has_no_mean() -> None:
    found = {each.measurement: each for each in scores(FAMILIES["amplitude_memory_few_periods"], 4)}
    assert found["current_fundamental"].answered <= 1
    assert found["current_thd_f"].answered == 4


@pytest.mark.parametrize(
    "name",
    [
        "amplitude_memory_few_periods",
        "decaying_dc",
        "regimes_slight_few_periods",
        *at_length("amplitude_memory_short"),
    ],
)
def test_a_value_without_an_uncertainty_says_why(name: str) -> None:
    bare = [
        each
        for number in range(2)
        for each, _ in FAMILIES[name].trial(np.random.default_rng(number))
        if math.isfinite(each.value) and each.uncertainty is None and not each.name.startswith("harmonic_")
    ]
    assert name == "decaying_dc" or bare
    assert all(each.uncertainty_reason for each in bare), bare


@pytest.mark.parametrize(("name", "is_noise"), [("swing_encoder_512", True), ("speed_walk", False)])
def test_steps_of_an_angle_count_at_both_ends_unless_they_are_its_noise(name: str, is_noise: bool) -> None:
    """512 counts scatter about the angle; of ten thousand, five a sample, all may lie alike."""
    found = {each.name: each for each, _ in FAMILIES[name].trial(np.random.default_rng(3))}
    uncertain = found["fundamental_frequency"].uncertainty
    assert uncertain is not None
    budget = {each.name: each.standard for each in uncertain.budget}
    noise = budget["noise of the angle at both ends"]
    assert (budget.get("resolution of the angle", 0.0) < noise) == is_noise


@pytest.mark.parametrize("name", ["sensor_second_order_1", *at_length("sensor_lag_1", "sensor_known_2")])
def test_what_a_sensor_took_off_is_within_its_uncertainty(name: str) -> None:
    found = {each.measurement: each for each in scores(FAMILIES[name], 6)}
    for measurement in ("current_thd_f", "torque_ripple_rms", "torque_order_6p", "current_harmonics_5"):
        assert found[measurement].answered == 6
        assert found[measurement].rms < 1.4, found[measurement]
        assert found[measurement].verdict != "narrow", found[measurement]


@pytest.mark.parametrize("name", ["excited_no_dead_time", *at_length("excited", "excited_long")])
def test_inertia_and_friction_are_known_no_worse_than_they_err(name: str) -> None:
    found = {each.measurement: each for each in scores(FAMILIES[name], 6)}
    for measurement in ("motion_balance_J", "motion_balance_friction", "motion_balance_coulomb"):
        assert found[measurement].answered >= 5
        assert found[measurement].verdict != "narrow", found[measurement]
        assert found[measurement].rms > 0.3, found[measurement]


def test_the_families_that_stand_for_all_are_some_of_them_and_each_once() -> None:
    assert set(REPRESENTATIVE) < set(FAMILIES)
    assert len(set(REPRESENTATIVE)) == len(REPRESENTATIVE)


def test_numbers_that_are_exact_do_not_make_the_others_wide() -> None:
    """Nine of ten are known but for rounding, and stated so; one errs by as much as it says."""

    def trial(random: np.random.Generator) -> list[tuple[Measurement, float]]:
        rounding = random.uniform() < 0.9
        u = Uncertainty(1e-11 if rounding else 1e-3, "scatter")
        error = 1e-13 if rounding else float(random.choice([-1e-3, 1e-3]))
        return [(Measurement("frequency", 20.0 + error, "Hz", "as drawn", uncertainty=u), 20.0)]

    (found,) = scores(Family("exact", trial), 40)
    assert found.verdict == "holds"
    assert found.rms == pytest.approx(1.0)


def test_a_number_whose_truth_is_not_told_is_uncounted() -> None:
    told, untold, bare = (
        Measurement(
            name, 1.0, "A", "as drawn", uncertainty=Uncertainty(0.1, "scatter") if name != "bare" else None
        )
        for name in ("told", "untold", "bare")
    )
    found = list(selected([told, untold, bare], {"told": 1.08}))
    assert [(each.name, truth) for each, truth in found] == [("told", 1.08), ("untold", None)]
    verdicts = {each.measurement: each.verdict for each in scores(Family("half", lambda _: found), 10)}
    assert verdicts == {"told": "holds", "untold": "uncounted"}


def test_an_exact_number_with_an_uncertainty_is_wide() -> None:
    wide = Measurement("frequency", 20.0, "Hz", "as drawn", uncertainty=Uncertainty(1e-3, "scatter"))
    (found,) = scores(Family("wide", lambda _: [(wide, 20.0 + 1e-4)]), 40)
    assert found.verdict == "wide"


@pytest.mark.parametrize("damping", [None, 0.2, 0.999_999, 1.0, 1.000_001, 1.7, 250.0])
def test_answer_of_a_lag_is_that_of_its_transfer_function(damping: float | None) -> None:
    lag = Lag(30.0, damping)
    omega, time_s = lag.omega, np.linspace(0.0, 0.2, 2_001)
    below = [1.0, omega] if damping is None else [1.0, 2.0 * damping * omega, omega**2]
    _, expected = signal.step(([below[-1]], below), T=time_s)
    np.testing.assert_allclose(lag.step(time_s), expected, atol=1e-11)
    # the answer to a ramp is the mean of the answers to steps along it, here by Simpson's rule
    rise_s = 0.01
    steps = [lag.step(time_s - late_s) for late_s in np.linspace(0.0, rise_s, 401)]
    np.testing.assert_allclose(lag.ramp(time_s, rise_s), integrate.simpson(steps, axis=0) / 400, atol=1e-6)
    assert np.all(np.isfinite(lag.step(1e3 * time_s)))


def test_a_swing_that_is_far_above_the_noise_is_followed_in_every_record() -> None:
    found = {each.measurement: each for each in scores(FAMILIES["swing_2Hz_no_angle"], 3, 7)}
    for measurement in ("current_max_low_harmonic", "current_thd_f_subgroups", "harmonic_7"):
        assert found[measurement].answered == 3
        assert found[measurement].rms < 2.0
