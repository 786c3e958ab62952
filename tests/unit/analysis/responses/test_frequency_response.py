"""Frequency responses of systems with a Bode diagram in closed form, by two independent estimators."""

from __future__ import annotations

import math
from itertools import pairwise
from typing import Literal

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.typing import NDArray
from scipy import signal

from benchtool.analysis.responses.bode import Bode, analyze_response
from benchtool.analysis.responses.frequency_response import averaged_response, frequency_response
from benchtool.analysis.responses.periodic_response import periodic_response
from benchtool.block import Block, Channel, Gap
from benchtool.errors import AnalysisError
from tests.at_length import at_length

RATE_HZ = 10_000.0
ZETA, F_0_HZ = 0.4, 400.0


def _second_order() -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Numerator and denominator of a sampled resonance."""
    omega = 2 * np.pi * F_0_HZ
    numerator, denominator = signal.bilinear([omega**2], [1.0, 2 * ZETA * omega, omega**2], RATE_HZ)
    return np.asarray(numerator), np.asarray(denominator)


def _truth(frequency_Hz: NDArray[np.float64]) -> NDArray[np.complex128]:
    z = np.exp(2j * np.pi * frequency_Hz / RATE_HZ)
    b, a = _second_order()
    return np.asarray(np.polyval(b, z) / np.polyval(a, z))


def _prbs(periods: int, length: int = 10) -> NDArray[np.float64]:
    bits = signal.max_len_seq(length)[0]
    return np.tile(2.0 * bits - 1.0, periods)


def _chirp(rows: int) -> NDArray[np.float64]:
    time_s = np.arange(rows) / RATE_HZ
    return np.asarray(signal.chirp(time_s, 5.0, time_s[-1], 2000.0, "logarithmic", phi=-90.0))


def _filtered(x: NDArray[np.float64]) -> NDArray[np.float64]:
    return np.asarray(signal.lfilter(*_second_order(), x))


def _noise(rows: int, rms: float, seed: int = 0) -> NDArray[np.float64]:
    return rms * np.random.default_rng(seed).standard_normal(rows)


def _block(x: NDArray[np.float64], y: NDArray[np.float64], unit: str = "Nm") -> Block:
    channels = (Channel("torque_reference", "Nm"), Channel("torque", unit))
    return Block(channels, 0, 1, 1.0 / RATE_HZ, np.column_stack([x, y]))


def _bode(x: NDArray[np.float64], y: NDArray[np.float64], period: int | None = None) -> Bode:
    return analyze_response(_block(x, y), "torque_reference", "torque", period_rows=period)


def _values(bode: Bode) -> dict[str, float]:
    return {each.name: each.value for each in bode.measurements}


def test_both_estimators_agree_with_the_closed_form_within_their_errors() -> None:
    period = 1023
    x = _prbs(41)
    y = _filtered(x) + _noise(len(x), 0.05)
    whole = periodic_response(x[period:], y[period:], RATE_HZ, period)  # the transient is over
    x = _noise(len(x), 1.0, seed=1)
    welch = averaged_response(x, _filtered(x) + _noise(len(x), 0.05, seed=2), RATE_HZ, segment=2000)
    for found in (whole, welch):
        low = found.trusted & (found.frequency_Hz < 2000.0)
        off = found.response[low] / _truth(found.frequency_Hz[low]) - 1.0
        # real and imaginary part have the stated error each: the mean square is 2
        assert np.mean((np.abs(off) / found.error[low]) ** 2) == pytest.approx(2.0, rel=0.3)
    at_Hz = whole.frequency_Hz[whole.frequency_Hz < 800.0]
    between = np.interp(at_Hz, welch.frequency_Hz, welch.gain)
    np.testing.assert_allclose(between[2:], whole.gain[2 : len(at_Hz)], rtol=0.1)


@pytest.mark.parametrize("segment", [200, 1000])
def test_the_bin_next_to_dc_is_no_part_of_an_averaged_response(segment: int) -> None:
    """A Hann window is three bins wide: what is left of an offset falls into the first beside it."""
    x = _noise(20_000, 1.0)
    found = averaged_response(x, _filtered(x), RATE_HZ, segment)
    assert found.frequency_Hz[0] == pytest.approx(2.0 * RATE_HZ / segment)
    assert found.frequency_Hz[-1] == pytest.approx(RATE_HZ / 2)


def test_a_periodic_input_leaks_nothing() -> None:
    x = _prbs(6)
    y = _filtered(x)
    found = periodic_response(x[1023:], y[1023:], RATE_HZ, 1023)
    np.testing.assert_allclose(found.response, _truth(found.frequency_Hz), rtol=1e-6)
    assert np.all(found.coherence > 1.0 - 1e-9)


def test_numbers_of_the_resonance() -> None:
    x = _prbs(11)
    found = _values(_bode(x[1023:], _filtered(x)[1023:], 1023))
    grid_Hz = np.linspace(1.0, 3000.0, 300_000)
    gain, phase = np.abs(_truth(grid_Hz)), np.unwrap(np.angle(_truth(grid_Hz)))
    assert found["response_gain"] == pytest.approx(1.0, abs=2e-3)
    assert found["bandwidth_3dB"] == pytest.approx(grid_Hz[np.argmax(gain < math.sqrt(0.5))], rel=5e-3)
    assert found["bandwidth_90deg"] == pytest.approx(grid_Hz[np.argmax(phase < -np.pi / 2)], rel=5e-3)
    assert found["resonance_peak"] == pytest.approx(20 * math.log10(np.max(gain)), abs=0.02)
    assert found["coherence_min"] > 0.999


@given(st.integers(0, 40))
@settings(max_examples=10, deadline=None)
def test_a_delay_is_a_linear_phase_and_no_gain(rows: int) -> None:
    x = _prbs(6)
    bode = _bode(x, np.roll(x, rows), 1023)
    np.testing.assert_allclose(bode.response.gain, 1.0, rtol=1e-9)
    assert _values(bode)["response_delay"] == pytest.approx(rows / RATE_HZ, abs=1e-9)
    phase = bode.response.phase_rad
    np.testing.assert_allclose(phase, -2 * np.pi * bode.response.frequency_Hz * rows / RATE_HZ, atol=1e-6)
    if rows:
        assert _values(bode)["bandwidth_90deg"] == pytest.approx(RATE_HZ / 4 / rows, rel=1e-6)


@given(st.floats(0.01, 100.0), st.floats(-50.0, 50.0))
@settings(max_examples=20, deadline=None)
def test_scale_and_offset_change_the_gain_alone(scale: float, offset: float) -> None:
    x = _prbs(5)
    y = _filtered(x) + _noise(len(x), 0.02)
    one, other = (averaged_response(x, samples, RATE_HZ) for samples in (y, offset + scale * y))
    np.testing.assert_allclose(other.response, scale * one.response, rtol=1e-6, atol=1e-9 * scale)
    np.testing.assert_allclose(other.coherence, one.coherence, rtol=1e-6, atol=1e-9)


def test_a_chirp_shows_its_band_and_nothing_beyond() -> None:
    x = _chirp(40_000)
    y = _filtered(x) + _noise(len(x), 0.002)
    found = averaged_response(x, y, RATE_HZ)
    used_Hz = found.frequency_Hz[found.trusted]
    assert used_Hz[0] < 15.0
    assert 1800.0 < used_Hz[-1] < 2200.0
    inside = found.trusted & (found.frequency_Hz > 20.0) & (found.frequency_Hz < 1500.0)
    np.testing.assert_allclose(found.response[inside], _truth(found.frequency_Hz[inside]), atol=0.06)


def _lag(x: NDArray[np.float64]) -> NDArray[np.float64]:
    """First order, 300 Hz."""
    return np.asarray(signal.lfilter(*signal.butter(1, 300.0, fs=RATE_HZ), x))


def _lag_truth(frequency_Hz: NDArray[np.float64]) -> NDArray[np.complex128]:
    return np.asarray(signal.freqz(*signal.butter(1, 300.0, fs=RATE_HZ), frequency_Hz, fs=RATE_HZ)[1])


@pytest.mark.parametrize("law", ["logarithmic", *at_length("linear")])
@pytest.mark.parametrize("rest", [0, 2000])
@pytest.mark.parametrize("noise", [0.0, 0.003])
def test_one_sweep_through_a_lag_reads_the_lag_within_the_stated_errors(
    law: Literal["linear", "logarithmic"], rest: int, noise: float
) -> None:
    sweep = signal.chirp(np.arange(20_000) / RATE_HZ, 5.0, 2.0, 2000.0, law, phi=-90.0)
    x = np.concatenate([np.zeros(rest), sweep, np.zeros(rest)])
    y = _lag(x) + _noise(len(x), noise)

    bode = _bode(x, y)

    found, response = {each.name: each for each in bode.measurements}, bode.response
    assert ("at rest" in response.method) == (rest > 0)
    off = response.response[response.trusted] / _lag_truth(response.frequency_Hz[response.trusted]) - 1.0
    error = response.error[response.trusted]
    if noise:
        assert np.mean((np.abs(off) / error) ** 2) == pytest.approx(2.0, rel=0.5)
    else:
        assert np.median(np.abs(off)) < 1e-5
    reference_Hz = response.frequency_Hz[response.reference]
    expected = {"response_gain": 1.0, "resonance_peak": 0.0, "bandwidth_3dB": 300.0}
    for name, value in expected.items():
        uncertainty = found[name].uncertainty
        assert uncertainty is not None
        # the greatest of many values is high by its error, and by more with more of them
        spread = 4.0 if name == "resonance_peak" else 3.0
        least = 1e-3 if name != "bandwidth_3dB" else 0.3
        assert abs(found[name].value - value) < spread * uncertainty.standard + least
        assert uncertainty.standard < (0.3 if name == "resonance_peak" else 0.1 * value)
    assert reference_Hz < 20.0 or (law, rest) == ("linear", 0)


def test_a_resonance_is_read_from_one_sweep() -> None:
    x = np.concatenate([np.zeros(500), _chirp(40_000), np.zeros(3000)])
    found = _values(_bode(x, _filtered(x) + _noise(len(x), 0.001)))
    gain = np.abs(_truth(np.linspace(1.0, 3000.0, 300_000)))
    assert found["resonance_peak"] == pytest.approx(20 * math.log10(np.max(gain)), abs=0.05)


def test_the_reference_is_no_badly_excited_edge() -> None:
    time_s = np.arange(20_000) / RATE_HZ
    x = np.asarray(signal.chirp(time_s, 100.0, 2.0, 1000.0)) + _noise(20_000, 2e-3, 3)
    found = _bode(x, 2.0 * x + _noise(len(x), 2e-3, 4)).response
    assert found.frequency_Hz[found.trusted][0] < 80.0
    assert found.frequency_Hz[found.reference] > 80.0


def test_a_period_that_is_not_the_inputs_is_refused() -> None:
    x = _prbs(8)
    for wrong in (1000, 1022, 1024):
        with pytest.raises(AnalysisError, match=f"repeats itself every {wrong} samples"):
            _bode(x, _filtered(x), wrong)
    noisy = x + _noise(len(x), 0.3)
    assert frequency_response(noisy, _filtered(x), RATE_HZ, period=1023).averages == 8


def test_noise_that_the_input_does_not_make_is_not_taken_for_a_response() -> None:
    x = _prbs(6)
    with pytest.raises(AnalysisError, match="no frequency of 'torque_reference' shows in 'torque'"):
        _bode(x, _noise(len(x), 1.0), 1023)


def test_few_averages_ask_for_more_coherence() -> None:
    y = _noise(40_960, 1.0, 2)
    least = [
        periodic_response(np.tile(_noise(len(y) // n, 1.0, 1), n), y, RATE_HZ, len(y) // n).least_coherence
        for n in (4, 5, 10, 20)
    ]
    x = np.tile(_noise(4096, 1.0, 1), 5)
    assert least[0] > 0.95
    assert all(more >= fewer for more, fewer in pairwise(least))
    assert least[-1] == 0.8
    # by chance alone 0.2^4 of 2048 frequencies would have 0.8 of five averages: three of them
    wrong = [
        np.count_nonzero(periodic_response(x, _noise(len(x), 1.0, seed), RATE_HZ, 4096).trusted)
        for seed in range(10)
    ]
    assert np.count_nonzero(wrong) <= 2


def test_the_stated_error_is_the_scatter_of_repeated_experiments() -> None:
    x = _prbs(9, 8)[255:]
    clean = _filtered(_prbs(9, 8))[255:]
    runs = [periodic_response(x, clean + _noise(len(x), 0.3, seed), RATE_HZ, 255) for seed in range(200)]
    gains = np.array([run.gain for run in runs])[:, :20]
    stated = np.array([run.gain * run.error for run in runs])[:, :20]
    assert np.mean(np.std(gains, axis=0)) == pytest.approx(np.mean(stated), rel=0.1)
    phases = np.array([np.angle(run.response / run.response[0]) for run in runs])
    assert np.all(np.isfinite(phases))


def test_few_periods_count_where_they_tell_enough_and_are_averaged_over_segments_otherwise() -> None:
    x, y = _prbs(3)[1023:], _filtered(_prbs(3))[1023:]
    assert "2 periods" in frequency_response(x, y, RATE_HZ, period=1023).method
    lost = y + _noise(len(y), 30.0 * float(np.std(y)))
    assert "Welch" in frequency_response(x, lost, RATE_HZ, period=1023).method
    x4, y4 = _prbs(5)[1023:], _filtered(_prbs(5))[1023:]
    assert "4 periods" in frequency_response(x4, y4, RATE_HZ, period=1023).method
    assert "Welch" in frequency_response(x[:2000], y[:2000], RATE_HZ, period=1023).method
    with pytest.raises(AnalysisError, match="hold 1 whole periods of 1023, at least 2"):
        periodic_response(x[:1500], y[:1500], RATE_HZ, 1023)
    with pytest.raises(AnalysisError, match="half-overlapping segments"):
        averaged_response(x[:100], y[:100], RATE_HZ, segment=60)


@pytest.mark.parametrize("noise", [0.0, 0.02])
def test_periods_in_which_the_answer_sets_in_are_left_out(noise: float) -> None:
    """A square wave of 50 Hz from rest, of which the first period has the answer from rest as well."""
    x = np.tile(np.repeat([1.0, -1.0], 100), 10)
    y = _filtered(x) + _noise(len(x), noise)
    found = frequency_response(x, y, RATE_HZ, period=200)
    assert found.method.endswith("after 1 in which the answer sets in")
    at = found.well_excited
    off = np.abs(found.response[at] / _truth(found.frequency_Hz[at]) - 1.0)
    if noise:
        assert np.mean((off / found.error[at]) ** 2) == pytest.approx(2.0, rel=0.5)
        settled = [
            frequency_response(x[200:], _filtered(x)[200:] + _noise(1800, noise, seed), RATE_HZ, period=200)
            for seed in range(10)
        ]
        assert sum("sets in" in each.method for each in settled) <= 1
    else:
        assert np.max(off) < 1e-3


def test_what_is_not_reached_is_undefined_and_says_why() -> None:
    x = _prbs(6)
    by_name = {each.name: each for each in _bode(x, 2.0 * x, 1023).measurements}
    for name in ("bandwidth_3dB", "bandwidth_90deg"):
        assert math.isnan(by_name[name].value)
        assert by_name[name].reason
    assert by_name["response_gain"].value == pytest.approx(2.0)
    assert by_name["response_gain"].uncertainty is not None


def test_units_table_and_refusals() -> None:
    x = _prbs(6)
    bode = analyze_response(_block(x, x, "A"), "torque_reference", "torque", period_rows=1023)
    assert bode.gain_unit == "A/Nm"
    (table,) = bode.tables
    assert table.name == "frequency_response"
    assert len(table.rows) == 511
    assert {len(row) for row in table.rows} == {len(table.columns)}
    holed = _block(x, x)
    holed = Block(holed.channels, 0, 1, holed.tick_s, holed.data, (Gap(5, 2),))
    with pytest.raises(AnalysisError, match="2 rows are missing"):
        analyze_response(holed, "torque_reference", "torque")
    with pytest.raises(AnalysisError, match="'torque' is constant"):
        _bode(x, np.zeros(len(x)))
    with pytest.raises(AnalysisError, match="as many of each are needed"):
        frequency_response(x, x[:-1], RATE_HZ)


@pytest.mark.parametrize("lowest_Hz", [5.0, 40.0])
def test_the_bandwidth_refers_to_the_gain_at_rest_however_low_the_sweep_begins(lowest_Hz: float) -> None:
    """A lag of 100 Hz has lost 0.6 dB at 40 Hz, which is no part of its reference."""
    time_s = np.arange(20_000) / RATE_HZ
    sweep = signal.chirp(time_s, lowest_Hz, 2.0, 1500.0, phi=-90.0)
    x = np.concatenate([np.zeros(500), sweep, np.zeros(1500)])
    y = signal.lfilter(*signal.butter(1, 100.0, fs=RATE_HZ), x) + _noise(len(x), 0.003)
    found = {each.name: each for each in _bode(x, np.asarray(y)).measurements}
    for name, expected in (("response_gain", 1.0), ("bandwidth_3dB", 100.0)):
        uncertainty = found[name].uncertainty
        assert uncertainty is not None
        assert abs(found[name].value - expected) < 3.0 * uncertainty.standard
        assert uncertainty.standard < 0.02 * expected


def test_errors_of_the_response_bias_neither_bandwidth_nor_peak() -> None:
    """Of a noisy curve the first point below a level comes early, and the greatest is too great."""
    off: dict[str, list[float]] = {"bandwidth_3dB": [], "bandwidth_90deg": [], "resonance_peak": []}
    frequency_Hz = np.linspace(0.5, 3000.0, 60_000)
    gain, phase = np.abs(_truth(frequency_Hz)), np.unwrap(np.angle(_truth(frequency_Hz)))
    truth = {
        "bandwidth_3dB": frequency_Hz[np.argmax(gain < math.sqrt(0.5))],
        "bandwidth_90deg": frequency_Hz[np.argmax(phase < -np.pi / 2)],
        "resonance_peak": 20.0 * math.log10(np.max(gain)),
    }
    x = _prbs(9)
    for seed in range(12):
        y = _filtered(x) + _noise(len(x), 0.1, seed)
        for each in _bode(x[1023:], y[1023:], 1023).measurements:
            if each.name in off:
                assert each.uncertainty is not None
                off[each.name].append((each.value - truth[each.name]) / each.uncertainty.standard)
    for name, errors in off.items():
        assert abs(np.mean(errors)) < 1.0, name
        assert np.mean(np.abs(errors) <= 2.0) >= 0.8, name


def test_margins_of_a_loop_with_a_delay() -> None:
    """An integrator with a delay d behind unity feedback: phase margin 90 degrees - omega_c d."""
    omega_c, rows = 2 * np.pi * 150.0, 6
    delay_s = rows / RATE_HZ
    x = _noise(60_000, 1.0, 5)
    gain = omega_c / RATE_HZ
    b = np.zeros(rows + 1)
    a = np.zeros(rows + 1)
    a[0], a[1], b[rows] = 1.0, -1.0, gain
    y = signal.lfilter(b, a + b, x)  # of L / (1 + L) with L = gain z^-rows / (1 - z^-1)
    found = {each.name: each for each in _bode(x, np.asarray(y)).measurements}
    grid = np.linspace(5.0, 4000.0, 400_000)
    z = np.exp(2j * np.pi * grid / RATE_HZ)
    opened = gain * z**-rows / (1.0 - 1.0 / z)
    at = int(np.argmax(np.abs(opened) < 1.0))
    turned = int(np.argmax(np.unwrap(np.angle(opened)) < -np.pi))
    expected = {
        "crossover": grid[at],
        "phase_margin": 180.0 + math.degrees(np.angle(opened[at])),
        "gain_margin": -20.0 * math.log10(abs(opened[turned])),
        "sensitivity_peak": float(np.max(np.abs(1.0 / (1.0 + opened)))),
    }
    assert expected["phase_margin"] == pytest.approx(90.0 - math.degrees(omega_c * delay_s), abs=3.0)
    for name, value in expected.items():
        assert found[name].value == pytest.approx(value, rel=0.02), name


def test_what_the_frequencies_used_do_not_show_is_null_with_a_reason() -> None:
    """A lag far above the frequencies played neither peaks nor falls in them, nor does its S reach 1."""
    x = signal.lfilter(*signal.butter(6, 0.02), _noise(20_000, 1.0, seed=2))
    omega_T = 2.0 * math.pi * 1000.0 / RATE_HZ
    y = signal.lfilter([1.0 - math.exp(-omega_T)], [1.0, -math.exp(-omega_T)], x)
    found = {each.name: each for each in _bode(x, y + _noise(len(x), 1e-4)).measurements}
    for name, reason in (("sensitivity_peak", "reaches 1 above"), ("resonance_peak", "may be above")):
        assert math.isnan(found[name].value)
        assert reason in found[name].reason, found[name]


def test_a_drift_is_no_response() -> None:
    x = _prbs(11)
    y = _filtered(x) + np.linspace(0.0, 2.0, len(x))
    drifting, still = (
        frequency_response(x[1023:], samples[1023:], RATE_HZ, period=1023) for samples in (y, _filtered(x))
    )
    assert np.max(np.abs(drifting.response[:400] - still.response[:400])) < 1e-6


def test_a_sharp_resonance_in_noise_has_its_height() -> None:
    """A pole 2 Hz wide, in a record whose bins are 0.5 Hz apart."""
    omega, zeta = 2.0 * math.pi * 40.0, 0.05
    system = signal.bilinear([omega**2], [1.0, 2.0 * zeta * omega, omega**2], RATE_HZ)
    x = _noise(20_000, 1.0, seed=4)
    y = np.asarray(signal.lfilter(*system, x))
    found = {each.name: each for each in _bode(x, y + _noise(len(y), 1e-3 * float(np.std(y)))).measurements}
    peak = found["resonance_peak"]
    assert peak.value == pytest.approx(20.0 * math.log10(0.5 / zeta), abs=0.1)
    assert peak.uncertainty is not None
    assert peak.uncertainty.standard < 0.3


def test_few_periods_have_errors_that_hold_for_the_gain_at_rest() -> None:
    x = _prbs(5)
    truth, errors = 1.0, []
    for seed in range(9):
        bode = _bode(x[1023:], (_filtered(x) + _noise(len(x), 1e-3, seed))[1023:], period=1023)
        (gain,) = (each for each in bode.measurements if each.name == "response_gain")
        assert gain.uncertainty is not None
        errors.append((gain.value - truth) / gain.uncertainty.standard)
    assert np.sqrt(np.mean(np.square(errors))) < 1.5


def test_a_bandwidth_of_which_the_errors_say_nothing_is_null() -> None:
    """The phase of a lag of first order and half a sample of hold, which passes -90 degrees slowly."""
    x = _chirp(20_000)
    lag = math.exp(-2.0 * math.pi * 100.0 / RATE_HZ)
    y = np.asarray(signal.lfilter([0.0, 1.0 - lag], [1.0, -lag], x))
    noisy = [_bode(x, y + _noise(len(y), 0.15 * float(np.std(y)), seed)) for seed in range(5)]
    for bode in noisy:
        (found,) = (each for each in bode.measurements if each.name == "bandwidth_90deg")
        if math.isnan(found.value):
            assert found.reason
        else:
            assert found.uncertainty is not None
            assert found.uncertainty.standard <= 0.2 * found.value
            assert abs(found.value - 562.0) < 5.0 * found.uncertainty.standard + 10.0
