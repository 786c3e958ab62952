"""What noise must not do to a frequency response: stand for it, pick its frequencies, hide what is read."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import signal

from benchtool.analysis import FrequencyResponse, Measurement, analyze_response
from benchtool.analysis.measurement import Basis
from benchtool.analysis.quantisation.swept_steps import error_of_input_steps
from benchtool.analysis.responses.estimated_response import without_jumps
from benchtool.analysis.responses.frequency_response import frequency_response
from benchtool.analysis.responses.gain_at_rest import gain_at_rest
from benchtool.analysis.responses.margins import margins
from benchtool.analysis.responses.periodic_response import period_of, periodic_response
from benchtool.analysis.responses.response_curve import ResponseCurve
from benchtool.block import Block
from tests.at_length import at_length

RATE_HZ = 10_000.0
PERIOD = 2000
BASIS = Basis(samples=1, sample_rate_Hz=1.0, duration_s=1.0, window="", reference="", gaps=0)

Floats = NDArray[np.float64]


def _lines(periods: int, top_Hz: float = 1500.0, seed: int = 1) -> Floats:
    """Sines of equal size at every line of the period up to a frequency, of unit rms."""
    last = round(top_Hz * PERIOD / RATE_HZ)
    bins = np.zeros(PERIOD // 2 + 1, dtype=np.complex128)
    bins[1 : last + 1] = np.exp(2j * np.pi * np.random.default_rng(seed).random(last))
    x = np.fft.irfft(bins)
    return np.tile(x / np.std(x), periods)


def _lag(corner_Hz: float) -> tuple[Floats, Floats]:
    pole = math.exp(-2.0 * math.pi * corner_Hz / RATE_HZ)
    return np.array([0.0, 1.0 - pole]), np.array([1.0, -pole])


def _measured(x: Floats, y: Floats, begin: int = 0, period: int | None = None) -> dict[str, Measurement]:
    block = Block.from_arrays(RATE_HZ, {"x": "Nm", "y": "Nm"}, x=x, y=y)
    found = analyze_response(block, "x", "y", begin_row=begin, period_rows=period)
    return {each.name: each for each in found.measurements}


def _missed(found: Measurement, truth: float) -> float:
    """Error over standard uncertainty."""
    assert found.uncertainty is not None, found.reason
    return (found.value - truth) / found.uncertainty.standard


def _in_loop(noise: float, periods: int = 9) -> tuple[Floats, Floats]:
    """Controller output and output of a lag of 100 Hz with a controller of gain 3, excited at the
    reference."""
    reference = _lines(periods, 2000.0)
    numerator, denominator = _lag(100.0)
    around = 3.0 * numerator + denominator
    disturbance = noise * np.random.default_rng(2).standard_normal(len(reference))
    y = signal.lfilter(3.0 * numerator, around, reference) + signal.lfilter(denominator, around, disturbance)
    return np.asarray(3.0 * (reference - y)), np.asarray(y)


def test_noise_that_goes_around_a_loop_is_no_response() -> None:
    """Where there is only noise, output over input is -1 over the controller, and as coherent as can be."""
    x, y = _in_loop(0.2)
    found = periodic_response(x[PERIOD:], y[PERIOD:], RATE_HZ, PERIOD)
    assert float(np.max(found.frequency_Hz[found.trusted])) < 2010.0
    measured = _measured(x, y, PERIOD, PERIOD)
    assert abs(_missed(measured["response_gain"], 1.0)) < 4.0
    assert measured["response_gain"].value == pytest.approx(1.0, abs=0.1)


def test_noise_of_the_input_lowers_no_gain() -> None:
    missed = []
    for seed in range(9):
        x = _lines(7, seed=seed)
        y = signal.lfilter(*_lag(100.0), x)
        noisy = x + 0.3 * np.random.default_rng(seed).standard_normal(len(x))
        missed.append(_missed(_measured(noisy, np.asarray(y), PERIOD, PERIOD)["response_gain"], 1.0))
    assert abs(float(np.mean(missed))) < 0.9
    assert float(np.sqrt(np.mean(np.square(missed)))) < 1.6


def test_no_gain_is_picked_because_noise_enlarged_it() -> None:
    """Equal gains, of which the errors begin to be too large: the mean, weighted by errors, is not biased."""
    count = 4000
    error = np.geomspace(0.03, 0.3, count)
    random = np.random.default_rng(5)
    response = 1.0 + error * (random.standard_normal(count) + 1j * random.standard_normal(count))
    own = error / np.abs(response)
    every = np.ones(count, dtype=bool)
    found = FrequencyResponse(
        np.arange(1.0, count + 1.0),
        np.asarray(response, dtype=np.complex128),
        every.astype(float),
        own,
        np.ones(count),
        every,
        every,
        9.0,
        1,
        "",
    )
    late = error > 0.09
    used = found.trusted & late
    even = float(np.average(np.log(found.gain[used]), weights=1.0 / found.error_of_many[used] ** 2))
    assert np.count_nonzero(used) > 300
    # picked and weighted by their own errors they are too large
    picked = (1.0 / (1.0 + 16.0 * own**2) > 0.8) & late
    biased = float(np.average(np.log(found.gain[picked]), weights=1.0 / own[picked] ** 2))
    assert biased > 0.03
    assert abs(even) < 0.3 * biased


@pytest.mark.slow
def test_the_gain_at_rest_is_not_biased_by_gains_of_large_errors() -> None:
    frequency_Hz = np.arange(5.0, 1000.0, 1.25)
    truth = 1.0 / (1.0 - (frequency_Hz / 200.0) ** 2 + 0.1j * frequency_Hz / 200.0)
    error = 0.004 / np.abs(truth)
    random = np.random.default_rng(7)
    missed = []
    for _ in range(36):
        noise = error * (random.standard_normal(len(truth)) + 1j * random.standard_normal(len(truth)))
        found = gain_at_rest(frequency_Hz, np.asarray(truth * (1.0 + noise)), error)
        missed.append((found.gain - 1.0) / (found.gain * found.relative_error))
    assert abs(float(np.mean(missed))) < 0.25
    assert 0.6 < float(np.sqrt(np.mean(np.square(missed)))) < 1.2


def test_margins_are_read_where_noise_leaves_1_minus_T() -> None:
    """A resonance of unit gain at rest: below some 10 Hz 1 - T is less than the noise, of any angle."""
    frequency_Hz = np.arange(1.0, 2000.0, 2.0)
    s = 1j * frequency_Hz / 300.0
    truth = np.exp(-2j * np.pi * frequency_Hz * 2e-4) / (1.0 + 0.4 * s + s**2)
    opened = truth / (1.0 - truth)
    turned = int(np.argmax(np.unwrap(np.angle(opened)) < -math.pi))
    error = 0.01 / np.abs(truth)
    for seed in range(8):
        random = np.random.default_rng(seed)
        noise = error * (random.standard_normal(len(s)) + 1j * random.standard_normal(len(s)))
        found = {each.name: each for each in margins(frequency_Hz, truth * (1.0 + noise), error, BASIS)}
        margin = found["gain_margin"]
        assert math.isnan(margin.value) or abs(_missed(margin, -20.0 * math.log10(abs(opened[turned])))) < 4.0
        assert math.isfinite(found["crossover"].value)


def test_a_loop_that_noise_hides_has_no_margins() -> None:
    frequency_Hz = np.arange(1.0, 50.0)
    noise = 0.3 * np.random.default_rng(0).standard_normal(len(frequency_Hz))
    found = {
        each.name: each for each in margins(frequency_Hz, np.exp(1j * noise), np.full(len(noise), 0.3), BASIS)
    }
    for name in ("crossover", "phase_margin", "gain_margin"):
        assert "noise hides 1 - T" in found[name].reason


@pytest.mark.parametrize(("last_Hz", "is_known"), [(250.0, False), (3000.0, True)])
def test_a_sensitivity_that_has_not_fallen_is_no_peak(last_Hz: float, is_known: bool) -> None:
    frequency_Hz = np.arange(5.0, last_Hz, 5.0)
    closed = np.exp(-2j * np.pi * frequency_Hz * 5e-4) / (1.0 + 1j * frequency_Hz / 100.0)
    found = {each.name: each for each in margins(frequency_Hz, closed, np.full(len(closed), 1e-3), BASIS)}
    peak = found["sensitivity_peak"]
    assert math.isfinite(peak.value) == is_known
    assert is_known or "has not clearly fallen" in peak.reason


@pytest.mark.parametrize("damping", [0.3, 0.45])
def test_a_level_between_few_frequencies_is_as_uncertain_as_they_are_apart(damping: float) -> None:
    frequency_Hz = np.geomspace(5.0, 1500.0, 12)
    missed = []
    for corner_Hz in np.linspace(150.0, 250.0, 21):
        s = 1j * frequency_Hz / corner_Hz
        response = 1.0 / (1.0 + 2.0 * damping * s + s**2)
        found = ResponseCurve.of_phase(frequency_Hz, response, np.full(12, 1e-4), 0.1).falls_to(
            -0.5 * math.pi
        )
        assert found is not None
        assert found.frequency_Hz == pytest.approx(corner_Hz, rel=0.03)
        missed.append((found.frequency_Hz - corner_Hz) / found.standard_Hz)
    assert max(map(abs, missed)) < 2.0


def test_a_level_that_no_value_is_clearly_below_is_not_passed() -> None:
    frequency_Hz = np.arange(10.0, 400.0, 10.0)
    values = 1.0 + 0.05 * np.random.default_rng(1).standard_normal(len(frequency_Hz))
    values[-1] = -0.01
    found = ResponseCurve(frequency_Hz, values, np.full(len(values), 0.05), 10.0).falls_to(0.0)
    assert found is not None
    assert "whether or where" in found.undefined_because


def test_the_greatest_of_many_errors_is_no_resonance() -> None:
    """A lag far above the frequencies used has no peak, in any of twelve records of noise."""
    for seed in range(12):
        random = np.random.default_rng(seed)
        x = random.standard_normal(6000)
        y = signal.lfilter(*_lag(3000.0), x) + 0.05 * random.standard_normal(len(x))
        peak = _measured(x, np.asarray(y))["resonance_peak"]
        assert math.isnan(peak.value) or peak.value < 0.1, seed


@pytest.mark.parametrize(("damping", "apart_Hz"), [(0.4, 1.0), *at_length((0.15, 1.0))])
def test_a_peak_of_many_frequencies_is_neither_raised_nor_lowered(damping: float, apart_Hz: float) -> None:
    frequency_Hz = np.arange(apart_Hz, 300.0, apart_Hz)
    s = 1j * frequency_Hz / 100.0
    response = 1.0 / (1.0 + 2.0 * damping * s + s**2)
    truth_dB = -20.0 * math.log10(2.0 * damping * math.sqrt(1.0 - damping**2))
    of_all = []
    for seed in range(40):
        noise = np.random.default_rng(seed).standard_normal((2, len(s)))
        noisy = response * (1.0 + 0.03 * (noise[0] + 1j * noise[1]))
        found_dB, standard_dB = ResponseCurve.of_gain(
            frequency_Hz, noisy, np.full(len(s), 0.03), 1.0
        ).resonance()
        of_all.append((found_dB - truth_dB) / standard_dB)
    assert abs(np.mean(of_all)) < 0.3
    assert 0.7 < math.sqrt(np.mean(np.square(of_all))) < 1.3


def test_a_delay_is_as_uncertain_as_its_line_not_as_the_phase_bends() -> None:
    x = _lines(6)
    y = signal.lfilter(*_lag(100.0), x) + 1e-3 * np.random.default_rng(0).standard_normal(len(x))
    delay = _measured(x, np.asarray(y), PERIOD, PERIOD)["response_delay"]
    assert delay.uncertainty is not None
    assert delay.uncertainty.standard < 1e-3 * delay.value


def test_an_input_tells_its_own_period() -> None:
    x = _lines(6)
    assert period_of(x) == PERIOD
    assert period_of(_lines(3)) is None  # too few to tell
    assert period_of(x + 0.1 * np.random.default_rng(0).standard_normal(len(x))) is None
    assert period_of(np.linspace(0.0, 1.0, 100)) is None
    y = np.asarray(signal.lfilter(*_lag(100.0), x))
    assert f"{PERIOD} samples" in frequency_response(x, y, RATE_HZ).method


def test_a_drift_between_two_rests_is_no_response() -> None:
    time_s = np.arange(20_000) / RATE_HZ
    x = np.pad(signal.chirp(time_s, 2.0, 2.0, 1200.0, phi=-90.0) * signal.windows.tukey(20_000, 0.02), 800)
    y = signal.lfilter(*_lag(100.0), x) + 1e-3 * np.random.default_rng(0).standard_normal(len(x))
    still = frequency_response(x, y, RATE_HZ)
    drifting = frequency_response(x, y + np.linspace(0.0, 0.5, len(x)), RATE_HZ)
    low = still.frequency_Hz < 100.0
    np.testing.assert_allclose(drifting.response[low], still.response[low], atol=5e-3)
    np.testing.assert_array_equal(drifting.trusted[low], still.trusted[low])


@pytest.mark.parametrize("frequency_Hz", [np.arange(5.0, 900.0, 5.0), np.geomspace(2.0, 900.0, 40)])
def test_a_lag_in_noise_has_no_resonance_on_average(frequency_Hz: Floats) -> None:
    relative, error = [], 0.06
    lag = 1.0 / (1.0 + 1j * frequency_Hz / 120.0)
    for seed in range(120):
        parts = np.random.default_rng(seed).standard_normal((2, len(lag)))
        noisy = lag * (1.0 + error * (parts[0] + 1j * parts[1]))
        curve = ResponseCurve.of_gain(frequency_Hz, noisy, np.full(len(lag), error), 3.0)
        peak_dB, standard_dB = curve.resonance()
        relative.append(peak_dB / standard_dB)
    assert abs(float(np.mean(relative))) < 0.4
    assert 0.5 < float(np.sqrt(np.mean(np.square(relative)))) < 1.2


def test_steps_of_an_output_on_few_levels_are_in_the_errors() -> None:
    numerator, denominator = _lag(120.0)
    x = _lines(6)
    y = signal.lfilter(numerator, denominator, x)[PERIOD:]
    step = 0.5 * float(np.std(y))
    read = step * np.round(y / step + 0.2)
    assert 5 < len(np.unique(read)) < 16
    found = periodic_response(x[PERIOD:], read, RATE_HZ, PERIOD)
    low = found.excited & (found.frequency_Hz < 500.0)
    _, truth = signal.freqz(numerator, denominator, worN=found.frequency_Hz[low], fs=RATE_HZ)
    off = np.abs(found.response[low] / truth - 1.0) / (np.sqrt(2.0) * found.error[low])
    assert 0.7 < float(np.sqrt(np.mean(off**2))) < 1.4


def test_steps_of_an_input_excite_nothing() -> None:
    """Between the lines of a stimulus an input in steps has power that is the same in all periods."""
    numerator, denominator = _lag(120.0)
    x = _lines(6)
    y = signal.lfilter(numerator, denominator, x)
    y += 0.01 * float(np.std(y)) * np.random.default_rng(2).standard_normal(len(y))
    step = 0.1 * float(np.std(x))
    read = step * np.round(x / step)
    assert len(np.unique(read)) > 16
    known = periodic_response(x[PERIOD:], y[PERIOD:], RATE_HZ, PERIOD)
    found = periodic_response(read[PERIOD:], y[PERIOD:], RATE_HZ, PERIOD)
    assert np.count_nonzero(found.trusted) > 0.9 * np.count_nonzero(known.trusted)
    assert not np.any(found.excited & ~known.excited)


@pytest.mark.parametrize("delay_s", [3e-4, 8e-4, 1.2e-3])
def test_a_delay_between_few_frequencies_has_no_jumps(delay_s: float) -> None:
    """At the highest of them it turns by nearly a whole turn from one to the next."""
    frequency_Hz = np.geomspace(1.0, 3000.0, 26)
    phase = -2.0 * np.pi * frequency_Hz * delay_s - 0.5 * np.pi
    np.testing.assert_allclose(without_jumps(frequency_Hz, np.exp(1j * phase)), phase, atol=1e-9)


def test_a_sharp_resonance_has_half_a_turn_and_no_jumps() -> None:
    frequency_Hz = 2.5 * np.arange(1.0, 200.0)
    random = np.random.default_rng(1)
    for centre_Hz in np.linspace(200.0, 202.5, 20).tolist():
        s = 1j * frequency_Hz / centre_Hz
        noise = 0.05 * random.standard_normal((2, len(s)))
        phase = without_jumps(frequency_Hz, (1.0 + noise[0] + 1j * noise[1]) / (1.0 + 2e-3 * s + s**2))
        assert abs(phase[-1] + np.pi) < 0.5


def test_a_crest_between_few_frequencies_may_be_the_top_of_a_resonance() -> None:
    """It is below the gain at rest where it was played, and above it between."""
    frequency_Hz = np.unique(np.geomspace(1.0, 600.0, 36).round()) * 2.5
    s, lowered = 2j * np.pi * frequency_Hz, 2.0 * np.pi * 160.0
    one, two = (1.0 + 0.1 * s / each + (s / each) ** 2 for each in (lowered, 1.35 * lowered))
    response = one / two / (1.0 + s / (2.0 * np.pi * 48.0))
    curve = ResponseCurve.of_gain(frequency_Hz, response, np.full(len(s), 1e-3), 3.0)
    fine = 2j * np.pi * np.linspace(150.0, 300.0, 20_000)
    one, two = (1.0 + 0.1 * fine / each + (fine / each) ** 2 for each in (lowered, 1.35 * lowered))
    peak_dB = 20.0 * np.log10(np.max(np.abs(one / two / (1.0 + fine / (2.0 * np.pi * 48.0)))))
    crest_dB = np.max(20.0 * np.log10(np.abs(response))[frequency_Hz > 150.0])
    assert crest_dB < 0.0 < peak_dB
    found_dB, standard_dB = curve.resonance()
    assert abs(found_dB - peak_dB) < 2.0 * standard_dB


def test_steps_of_an_input_that_sweeps_are_in_the_gain() -> None:
    rows = np.arange(20_000.0)
    x = signal.chirp(rows / 1e4, 5.0, 2.0, 2000.0, "logarithmic")
    off = []
    for amplitude in np.linspace(12.0, 13.0, 21).tolist():
        read = np.round(amplitude * x) / amplitude
        off.append(float(read @ x) / float(x @ x) - 1.0)
    stated = error_of_input_steps(np.round(12.5 * x) / 12.5)
    assert 0.5 < float(np.sqrt(np.mean(np.square(off)))) / stated < 1.5
    assert error_of_input_steps(x) == 0.0
