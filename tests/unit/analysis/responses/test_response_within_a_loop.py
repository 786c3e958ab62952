"""Responses of a plant within a loop, whose noise the controller feeds back to the input."""

from __future__ import annotations

import math

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy import signal

from benchtool.analysis import Measurement, Window, analyze_response
from benchtool.analysis.distributions import above_zero
from benchtool.analysis.responses.bode import FREQUENCY_RESPONSE, ResponseSettings
from benchtool.analysis.responses.frequency_response import averaged_response, frequency_response
from benchtool.analysis.responses.margins import Loop, loop_of
from benchtool.analysis.responses.response_curve import ResponseCurve
from benchtool.block import Block
from benchtool.errors import AnalysisError

RATE_HZ = 10_000.0
CONTROLLER = 3.0
CORNER_HZ = 100.0

Floats = NDArray[np.float64]


def _plant() -> tuple[Floats, Floats]:
    pole = math.exp(-2.0 * math.pi * CORNER_HZ / RATE_HZ)
    return np.array([0.0, 1.0 - pole]), np.array([1.0, -pole])


def _in_loop(stimulus: Floats, noise: float, seed: int = 0) -> tuple[Floats, Floats]:
    """Return what the controller gives and what the plant answers; the stimulus is the reference."""
    numerator, denominator = _plant()
    opened = CONTROLLER * numerator
    disturbance = noise * np.random.default_rng([seed, 1]).standard_normal(len(stimulus))
    y = signal.lfilter(opened, opened + denominator, stimulus)
    y = y + signal.lfilter(denominator, opened + denominator, disturbance)
    return np.asarray(CONTROLLER * (stimulus - y)), np.asarray(y)


def _noise(rows: int, seed: int = 0) -> Floats:
    return np.random.default_rng(seed).standard_normal(rows)


def _sweep(rows: int, rests: bool) -> Floats:
    rest = rows // 25 if rests else 0
    time_s = np.arange(rows - 2 * rest) / RATE_HZ
    swept = signal.chirp(time_s, 2.0, time_s[-1], 800.0, phi=-90.0)
    return np.asarray(np.pad(swept * signal.windows.tukey(len(swept), 0.02), rest) if rests else swept)


def _block(stimulus: Floats, x: Floats, y: Floats) -> Block:
    return Block.from_arrays(RATE_HZ, {"x": "A", "y": "Nm", "stimulus": "A"}, x=x, y=y, stimulus=stimulus)


def _truth(frequency_Hz: Floats) -> NDArray[np.complex128]:
    return np.asarray(signal.freqz(*_plant(), worN=frequency_Hz, fs=RATE_HZ)[1])


def _gain(block: Block, stimulus: str | None) -> Measurement:
    return next(
        each
        for each in analyze_response(block, "x", "y", stimulus=stimulus).measurements
        if each.name == "response_gain"
    )


def test_noise_of_the_loop_is_no_part_of_a_response_by_the_stimulus() -> None:
    stimulus = _noise(20_000, 5)
    x, y = _in_loop(stimulus, 0.4)
    found = frequency_response(x, y, RATE_HZ, stimulus=stimulus)
    band = (found.frequency_Hz > 20.0) & (found.frequency_Hz < 500.0)
    truth = _truth(found.frequency_Hz)
    off = np.abs(found.response - truth)[band] / (found.gain * found.error)[band]
    # real and imaginary part have the stated error each: the mean square is 2
    assert 1.5 < float(np.mean(off**2)) < 2.6
    assert abs(np.mean((found.response / truth)[band]) - 1.0) < 0.06
    without = frequency_response(x, y, RATE_HZ)
    assert abs(np.mean((without.response / truth)[band]) - 1.0) > 0.15
    assert "by the stimulus" in found.method


@pytest.mark.slow
def test_no_frequency_is_picked_because_noise_turned_its_response() -> None:
    """The residual is least for -1 over the controller: errors of single frequencies would prefer that."""
    turned: list[float] = []
    for seed in range(5):
        stimulus = _noise(30_000, 100 + seed)
        found = frequency_response(*_in_loop(stimulus, 0.2, seed), RATE_HZ, stimulus=stimulus)
        used = found.trusted & (found.frequency_Hz > 450.0) & (found.frequency_Hz < 800.0)
        turned.extend(np.angle(found.response[used] / _truth(found.frequency_Hz[used])))
    mean = float(np.mean(turned))
    assert abs(mean) < 4.0 * float(np.std(turned)) / math.sqrt(len(turned))


@pytest.mark.parametrize("rests", [True, False])
def test_a_sweep_shows_the_noise_that_a_loop_feeds_back(rests: bool) -> None:
    stimulus = _sweep(20_000, rests)
    x, y = _in_loop(stimulus, 0.2)
    found = frequency_response(x, y, RATE_HZ)
    assert float(np.max(found.frequency_Hz[found.trusted])) < 850.0
    gain = _gain(_block(stimulus, x, y), None)
    assert gain.uncertainty is not None
    assert gain.value == pytest.approx(1.0, abs=0.2)
    assert abs(gain.value - 1.0) < 4.0 * gain.uncertainty.standard


@pytest.mark.slow
def test_noise_of_the_input_is_no_bias_of_a_sweep() -> None:
    errors = []
    for seed in range(8):
        stimulus = _sweep(20_000, rests=True)
        y = np.asarray(signal.lfilter(*_plant(), stimulus)) + 0.01 * _noise(20_000, 50 + seed)
        gain = _gain(_block(stimulus, stimulus + 0.3 * _noise(20_000, seed), y), None)
        assert gain.uncertainty is not None
        errors.append((gain.value - 1.0) / gain.uncertainty.standard)
    assert float(np.sqrt(np.mean(np.square(errors)))) < 1.8


def test_what_excites_beside_a_sweep_is_no_noise_of_the_input() -> None:
    x = _sweep(20_000, rests=True) + 0.01 * _noise(20_000, 3)
    y = np.asarray(signal.lfilter(*_plant(), x)) + 1e-4 * _noise(20_000, 4)
    found = frequency_response(x, y, RATE_HZ)
    assert float(np.max(found.frequency_Hz[found.trusted])) > 2_000.0


def test_a_loop_with_much_noise_needs_a_stimulus_that_repeats_itself_only() -> None:
    period = 2000
    stimulus = np.tile(_noise(period, 9), 41)
    x, y = _in_loop(stimulus, 0.8)
    with pytest.raises(AnalysisError, match="of the input's power repeats itself"):
        frequency_response(x, y, RATE_HZ, period=period)
    found = frequency_response(x[period:], y[period:], RATE_HZ, period=period, stimulus=stimulus[period:])
    low = found.excited & (found.frequency_Hz < 100.0)
    off = np.abs(found.response[low] - _truth(found.frequency_Hz[low])) / (found.gain * found.error)[low]
    assert 1.0 < float(np.mean(off**2)) < 3.5


def test_averages_by_a_stimulus_are_not_biased() -> None:
    stimulus = _noise(60_000, 2)
    x, y = _in_loop(stimulus, 0.5)
    for by, least, most in ((stimulus, 0.0, 0.04), (None, 0.15, 1.0)):
        found = averaged_response(x, y, RATE_HZ, 2000, by)
        low = (found.frequency_Hz > 20.0) & (found.frequency_Hz < 60.0)
        assert least < abs(np.mean((found.response / _truth(found.frequency_Hz))[low]) - 1.0) < most


def test_the_channel_of_the_drive_counts_where_none_is_named() -> None:
    stimulus = _noise(20_000, 5)
    block = _block(stimulus, *_in_loop(stimulus, 0.3))
    window = Window(block, pole_pairs=2, torque_rated_Nm=1.0)
    for named, by in (("", " by stimulus"), ("stimulus", " by stimulus"), ("x", "")):
        settings = ResponseSettings(input="x", output="y", stimulus=named)
        found = FREQUENCY_RESPONSE.measure(window, settings)
        assert found.measurements[0].basis.reference.startswith(f"y over x{by};")
    at_rest = _block(np.zeros(20_000), *_in_loop(stimulus, 0.01))
    found = FREQUENCY_RESPONSE.measure(
        Window(at_rest, pole_pairs=2, torque_rated_Nm=1.0), ResponseSettings(input="x", output="y")
    )
    assert found.measurements[0].basis.reference.startswith("y over x;")


def test_a_stimulus_that_does_not_reach_the_input_is_named() -> None:
    stimulus = _noise(20_000, 5)
    block = _block(_noise(20_000, 6), *_in_loop(stimulus, 0.3))
    with pytest.raises(AnalysisError, match="no frequency of 'stimulus' shows in 'x'"):
        analyze_response(block, "x", "y", stimulus="stimulus")


def test_a_stimulus_is_a_channel_that_an_analysis_needs() -> None:
    named = ResponseSettings(input="x", output="y", stimulus="r")
    assert FREQUENCY_RESPONSE.missing(frozenset({"x", "y"}), named) == ("r",)
    assert FREQUENCY_RESPONSE.missing(frozenset({"x", "y"}), ResponseSettings(input="x", output="y")) == ()


@pytest.mark.parametrize("damping", [0.2, 0.45])
def test_where_no_parabola_follows_few_values_their_reciprocals_do(damping: float) -> None:
    errors, random = [], np.random.default_rng(2)
    for corner_Hz in np.linspace(120.0, 160.0, 15):
        frequency_Hz = np.geomspace(5.0, 1000.0, 46)
        s = 1j * frequency_Hz / corner_Hz
        response = np.exp(1e-6j * random.standard_normal(46)) / (1.0 + 2.0 * damping * s + s**2)
        found = ResponseCurve.of_phase(frequency_Hz, response, np.full(46, 1e-6), 0.5).falls_to(
            -0.5 * math.pi
        )
        assert found is not None
        assert found.frequency_Hz == pytest.approx(corner_Hz, rel=1e-5)
        errors.append((found.frequency_Hz - corner_Hz) / found.standard_Hz)
    assert 0.5 < float(np.sqrt(np.mean(np.square(errors)))) < 1.4


def test_noise_makes_no_cusp_of_a_peak() -> None:
    """A wide peak over many values with errors is known better than each of them."""
    frequency_Hz = np.linspace(10.0, 1000.0, 400)
    peak = 1.0 - ((frequency_Hz - 500.0) / 500.0) ** 2
    errors = []
    for seed in range(30):
        values = peak + 0.05 * _noise(400, seed)
        value, standard = ResponseCurve(frequency_Hz, values, np.full(400, 0.05), 1.0).greatest()
        assert standard < 0.06
        errors.append((value - 1.0) / standard)
    assert 0.5 < float(np.sqrt(np.mean(np.square(errors)))) < 1.6


def test_steps_of_a_converter_are_alike_at_neighbouring_frequencies() -> None:
    """The mean gain over a band is off by far more than independent errors would leave of it."""
    sweep = _sweep(40_000, rests=True)
    errors = []
    for size in np.linspace(0.9, 1.1, 8):
        y = np.asarray(signal.lfilter(*_plant(), size * sweep))
        for kept in (y, np.round(y * 32.0) / 32.0):
            found = frequency_response(sweep, kept, RATE_HZ)
            band = (found.frequency_Hz > 250.0) & (found.frequency_Hz < 280.0)
            off = np.mean((found.gain / (size * np.abs(_truth(found.frequency_Hz))))[band]) - 1.0
            stated = found.error_of_many[band]
            errors.append((off, float(np.sqrt(np.mean(stated**2) / np.count_nonzero(band)))))
    exact, rounded = np.array(errors[::2]), np.array(errors[1::2])
    assert np.all(np.abs(exact[:, 0]) < 1e-3)
    assert 0.3 < float(np.sqrt(np.mean((rounded[:, 0] / rounded[:, 1]) ** 2))) < 1.7


def test_what_cannot_be_negative_is_the_part_above_zero() -> None:
    drawn = np.random.default_rng(0).normal(0.0, 1.0, 2_000_000)
    for found in (-2.0, 0.0, 1.5):
        above = drawn[drawn > -found] + found
        median = float(np.median(above))
        spread = float(np.sqrt(np.mean((above - median) ** 2)))
        assert above_zero(found, 1.0) == pytest.approx((median, spread), rel=0.01)
    assert above_zero(-25.0, 1.0) == pytest.approx(above_zero(-25.01, 1.0), rel=0.01)
    assert above_zero(-1.0, 0.0) == (0.0, 0.0)


@pytest.mark.parametrize("noise", [0.0, 1e-3])
def test_a_response_to_the_control_error_is_the_open_loop_already(noise: float) -> None:
    """An integrator behind a lag of 2 ms and a delay of one row."""
    stimulus, pole = _sweep(20_000, True), math.exp(-1.0 / (RATE_HZ * 2e-3))
    numerator = np.array([0.0, 2.0 * math.pi * 50.0 / RATE_HZ * (1.0 - pole)])
    denominator = np.convolve([1.0, -1.0], [1.0, -pole])
    closed = denominator + np.pad(numerator, (0, 1))
    y = np.asarray(signal.lfilter(numerator, closed, stimulus))
    x = stimulus - y + noise * _noise(len(y), 1)
    block = Block.from_arrays(RATE_HZ, dict.fromkeys(("x", "y", "r"), "Nm"), x=x, y=y, r=stimulus)
    of_error, of_reference = (
        analyze_response(block, "x", "y", stimulus="r"),
        analyze_response(block, "r", "y"),
    )
    assert of_error.loop is Loop.OPEN
    assert of_reference.loop is Loop.CLOSED
    found, truth = ({one.name: one for one in each.measurements} for each in (of_error, of_reference))
    for name in ("crossover", "phase_margin", "sensitivity_peak"):
        assert found[name].value == pytest.approx(truth[name].value, rel=3e-3)
        assert "input being the stimulus less the output" in found[name].definition


def test_a_response_to_what_the_controller_gives_is_not_that_to_the_error() -> None:
    stimulus = _noise(2_000)
    x, y = _in_loop(stimulus, 0.1)
    assert loop_of(x, y, stimulus) is Loop.CLOSED
    assert loop_of(x / CONTROLLER, y, stimulus) is Loop.OPEN
    assert loop_of(x / CONTROLLER, y, None) is Loop.CLOSED
