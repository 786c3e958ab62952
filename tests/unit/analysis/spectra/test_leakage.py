"""Leakage and folding as theory has them, and the phase track against numpy's own unwrap and fit."""

from __future__ import annotations

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.polynomial import Polynomial
from numpy.typing import NDArray

from benchtool.analysis import amplitude_spectrum, coherent_spectrum, current_spectrum, track_angle
from benchtool.analysis.coherent.resampling import HALF_WIDTH, gain_error, interpolate, interpolate_all
from benchtool.block import Block, Channel

RATE_HZ = 10e3
COUNT = 4096
Array = NDArray[np.float64]


def response_dB(window: str, offset: float) -> float:
    """What a unit tone reads in a bin `offset` bins away from it, in dB, far from dc and the Nyquist bin."""
    bin_ = 1024
    tone = np.cos(2 * np.pi * (bin_ - offset) * np.arange(COUNT) / COUNT)
    spectrum = amplitude_spectrum(tone, RATE_HZ, "hann" if window == "hann" else "flattop")
    return 20 * float(np.log10(spectrum.amplitude[bin_]))


@pytest.mark.parametrize(("window", "loss_dB", "within_dB"), [("hann", 1.42, 0.01), ("flattop", 0.01, 0.005)])
def test_scalloping_loss_is_that_of_the_window(window: str, loss_dB: float, within_dB: float) -> None:
    assert response_dB(window, 0.0) == pytest.approx(0.0, abs=1e-6)
    assert -response_dB(window, 0.5) == pytest.approx(loss_dB, abs=within_dB)


def test_the_side_lobes_of_a_hann_window_begin_at_minus_31_and_a_half_dB() -> None:
    lobe = [response_dB("hann", offset) for offset in np.linspace(2.0, 3.0, 101)[1:-1]]

    assert max(lobe) == pytest.approx(-31.5, abs=0.1)
    # and fall by 18 dB an octave
    far = max(response_dB("hann", offset) for offset in np.linspace(16.0, 17.0, 21)[1:-1])
    further = max(response_dB("hann", offset) for offset in np.linspace(32.0, 33.0, 21)[1:-1])
    assert far - further == pytest.approx(18.0, abs=0.6)


def test_an_interharmonic_leaks_through_the_coherent_window_as_a_sinc() -> None:
    theta_e = 2 * np.pi * 50.0 * np.arange(8065, dtype=np.float64) / RATE_HZ
    spectrum = coherent_spectrum(
        np.cos(theta_e) + 0.1 * np.cos(20.5125 * theta_e), RATE_HZ, track_angle(theta_e, 1)
    )

    # 40 periods: the tone is at bin 820.5, half a bin from two bins, one and a half from the next two
    assert spectrum.periods == 40
    near, far = spectrum.amplitude[[820, 821]], spectrum.amplitude[[819, 822]]
    np.testing.assert_allclose(near, 0.1 * np.sinc(0.5), rtol=2e-2)
    np.testing.assert_allclose(far, 0.1 * np.abs(np.sinc(1.5)), rtol=4e-2)


@pytest.mark.parametrize("beyond_Hz", [9_650.0, 10_350.0, 19_650.0])
def test_a_tone_beyond_half_the_rate_stands_where_it_folds_and_the_basis_claims_no_more(
    beyond_Hz: float,
) -> None:
    number = np.arange(8065, dtype=np.float64)
    theta_e = 2 * np.pi * 50.0 * number / RATE_HZ
    current = np.cos(theta_e) + 0.1 * np.cos(2 * np.pi * beyond_Hz * number / RATE_HZ)
    block = Block((Channel("i_a", "A"),), 0, 1, 1.0 / RATE_HZ, current[:, np.newaxis])

    found = current_spectrum(block, "i_a", track_angle(theta_e, 1))

    rows = {row[0]: row for row in found.tables[0].rows}
    assert rows[7][1:3] == pytest.approx((350.0, 0.1), rel=1e-3)
    thd = next(each for each in found.measurements if each.name == "current_thd_f")
    assert thd.value == pytest.approx(10.0, rel=1e-3)
    assert thd.basis.bandwidth_Hz is not None
    assert thd.basis.bandwidth_Hz < 0.45 * RATE_HZ < beyond_Hz
    assert all((each.basis.bandwidth_Hz or 0.0) < 0.5 * RATE_HZ for each in found.measurements)


def test_interpolation_gives_what_sinusoids_are_between_the_samples() -> None:
    generator = np.random.default_rng(8)
    number = np.arange(3000, dtype=np.float64)
    positions = np.sort(generator.uniform(HALF_WIDTH - 1, 3000 - HALF_WIDTH - 1e-6, 2500))

    for frequency in (0.0, 0.001, 0.01, 0.07, 0.2, 0.35, 0.44):
        turned = 2.0 * np.pi * frequency
        found = interpolate(np.cos(turned * number + 1.0), positions)
        np.testing.assert_allclose(
            found, np.cos(turned * positions + 1.0), rtol=0.0, atol=1.5 * gain_error(frequency) + 1e-9
        )


def test_the_gain_is_within_its_bound_at_every_fraction_of_a_sample() -> None:
    number = np.arange(4 * HALF_WIDTH)
    positions = 2.0 * HALF_WIDTH + np.linspace(0.0, 1.0, 400, endpoint=False)
    for frequency in np.concatenate([np.geomspace(1e-4, 0.02, 40), np.linspace(0.021, 0.45, 200)]):
        turned = 2.0 * np.pi * frequency * number
        in_phase, in_quadrature = interpolate_all((np.cos(turned), np.sin(turned)), positions)
        off = np.max(np.abs(np.hypot(in_phase, in_quadrature) - 1.0))
        assert off <= gain_error(frequency) + 1e-13


@settings(max_examples=30, deadline=None)
@given(
    st.integers(40, 30_000),
    st.floats(0.02, 1.0),
    st.floats(-0.04, 0.04),
    st.booleans(),
    st.integers(0, 2**31),
)
def test_the_track_of_an_angle_is_the_quadratic_fit_of_what_numpy_unwraps(
    count: int, advance: float, change: float, wrapped: bool, seed: int
) -> None:
    number = np.arange(count)
    angle = 1.0 + advance * number * (1.0 + change * number / count) + 5.0 * 2 * np.pi / (advance * count)
    angle += np.random.default_rng(seed).normal(0.0, 1e-3, count)
    if advance * count < 8 * np.pi:
        return
    measured = np.mod(angle, 2 * np.pi) if wrapped else angle

    track = track_angle(measured, 3)

    unwrapped = 3 * np.unwrap(measured)
    expected = Polynomial.fit(number, unwrapped, 2)
    np.testing.assert_allclose(track.phase(number), expected(number), atol=1e-6)
    assert track.residual_rad == pytest.approx(
        np.sqrt(np.mean((unwrapped - expected(number)) ** 2)), rel=1e-4
    )


def test_rows_of_whole_periods_begin_where_the_phase_has_turned() -> None:
    theta_e = 2 * np.pi * np.arange(1001.0) / 100.0

    rows = track_angle(theta_e, 1).period_rows()

    np.testing.assert_array_equal(rows, np.arange(0, 1001, 100))


def test_beyond_a_hundred_periods_only_numbers_that_transform_fast_are_taken() -> None:
    theta_e = 2 * np.pi * np.arange(131 * 20 + 64 + 5.0) / 20.0

    spectrum = coherent_spectrum(np.cos(theta_e), RATE_HZ, track_angle(theta_e, 1))

    assert spectrum.periods == 128
    assert spectrum.amplitude[128] == pytest.approx(1.0, rel=1e-4)
