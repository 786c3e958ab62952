"""Bandwidth, resonance and delay of a frequency response between two channels of a capture, and its table."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace
from statistics import NormalDist
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.declaration import (
    Analysis,
    Drawing,
    Findings,
    Measured,
    Quantity,
    UnitOf,
    ratio_of_units,
)
from benchtool.analysis.distributions import above_zero
from benchtool.analysis.drawings import TORQUE
from benchtool.analysis.measurement import Basis, Measurement, Table
from benchtool.analysis.numbers import raw
from benchtool.analysis.responses.estimated_response import NEPER_DB, FrequencyResponse
from benchtool.analysis.responses.frequency_response import frequency_response
from benchtool.analysis.responses.gain_at_rest import gain_at_rest
from benchtool.analysis.responses.margins import Loop, loop_of, margins
from benchtool.analysis.responses.response_curve import Point, ResponseCurve
from benchtool.analysis.responses.response_delay import response_delay
from benchtool.analysis.sensitivity import NO_SENSORS
from benchtool.analysis.uncertainty import Uncertainty
from benchtool.analysis.validity import require_unbroken
from benchtool.analysis.window import PLAYED, Window
from benchtool.block import Block
from benchtool.document import Section
from benchtool.errors import AnalysisError

_HALF_POWER_DB = 20.0 * math.log10(math.sqrt(0.5))
_QUARTER_TURN = -0.5 * math.pi
_MOST_OF_THE_LEVEL = 0.3  # of the 3 dB: with a less certain gain at zero frequency there is no bandwidth
_BY_CHANCE = 0.05  # probability that the greatest of many errors looks like a peak
_STATISTICAL = "random error of the response"
_LOCALLY = "by a local parabola, or between few frequencies a cubic of the reciprocal of the response"

Floats = NDArray[np.float64]


@dataclass(frozen=True)
class Bode:
    """Result of `analyze_response`: the response of channel `output` to channel `input`, and its numbers.

    `gain_unit` is that of the gain, empty for a pure number; `loop` what the response is of the loop.
    """

    input: str
    output: str
    gain_unit: str
    response: FrequencyResponse
    measurements: tuple[Measurement, ...]
    tables: tuple[Table, ...]
    loop: Loop = Loop.CLOSED


def analyze_response(
    block: Block,
    input: str,
    output: str,
    *,
    begin_row: int = 0,
    end_row: int | None = None,
    period_rows: int | None = None,
    stimulus: str | None = None,
) -> Bode:
    """Return the response of a channel to another, from any excitation of the input.

    Within a loop the input holds noise of the output, that the controller feeds back: then the channel of
    the `stimulus` is needed, the signal that is played into the loop.

    Frequencies are used where the input has power (more than -50 dB of its greatest) and the coherence, of
    the error relative to the mean of neighbouring gains, is 0.8 or more, or above what few averages reach by
    chance; the others only appear in the table.

    Args:
        block: a capture without gaps, with both channels.
        begin_row, end_row: the rows to use; of a repeated stimulus those after its first period, when the
            transient has decayed.
        period_rows: after how many rows the stimulus repeats itself, if it does.
        stimulus: the channel of what excites the loop that holds the input; None, or the input itself, where
            nothing feeds back to it.

    Raises:
        AnalysisError: a gap, a missing channel, a dead signal, too few rows, or no frequency can be used.
    """
    require_unbroken(block)
    rows = slice(begin_row, end_row)
    by = "" if stimulus is None or stimulus == input else stimulus
    x, y = block.column(input)[rows], block.column(output)[rows]
    r = block.column(by)[rows] if by else None
    found = frequency_response(
        x,
        y,
        block.sample_rate_Hz,
        stimulus=r,
        period=period_rows,
        names=(input, output, by),
    )
    trusted = found.trusted
    if not np.any(trusted):
        raise AnalysisError(_why_none(found, input, output, by))
    band_Hz = found.frequency_Hz[trusted]
    ratio = f"{output} over {input} by {by}" if by else f"{output} over {input}"
    basis = Basis(
        samples=found.samples,
        sample_rate_Hz=block.sample_rate_Hz,
        duration_s=found.samples / block.sample_rate_Hz,
        bandwidth_Hz=float(band_Hz[-1]),
        window=found.method,
        reference=(
            f"{ratio}; {len(band_Hz)} of {len(trusted)} frequencies used, "
            f"{raw(band_Hz[0], 4)} Hz to {raw(band_Hz[-1], 4)} Hz, coherence "
            f"{raw(found.least_coherence, 2)} or more"
        ),
        gaps=0,
    )
    unit = ratio_of_units(block.unit(output), block.unit(input))
    loop = loop_of(x, y, r)
    measurements = tuple(_measurements(found, unit, basis, loop))
    return Bode(input, output, unit, found, measurements, (_table(found, unit, basis),), loop)


def _why_none(found: FrequencyResponse, input: str, output: str, stimulus: str) -> str:
    """Return why no frequency can be used."""
    if stimulus and not np.any(found.excited):
        return (
            f"no frequency of '{stimulus}' shows in '{input}': raise the stimulus, record longer, or name as "
            f"stimulus what is played into the loop; where nothing feeds back, '{input}' itself"
        )
    if not np.any(found.excited):
        return (
            f"'{input}' holds too much noise at every frequency, which a loop may feed back to it: name the "
            f"channel of the stimulus, or raise the stimulus"
        )
    return (
        f"no frequency of '{input}' shows in '{output}' with a coherence of {raw(found.least_coherence, 2)}, "
        f"the best has {raw(float(np.max(found.coherence)), 2)}: raise the stimulus or record longer"
    )


def _measurements(found: FrequencyResponse, unit: str, basis: Basis, loop: Loop) -> Iterator[Measurement]:
    trusted = found.trusted.copy()
    trusted[: found.reference] = False  # below it no gain is accurate
    frequency_Hz, error = found.frequency_Hz[trusted], found.error_of_many[trusted]
    response, shared = found.response[trusted], found.shared[trusted]
    gain, phase = found.gain[trusted], found.phase_rad[trusted]

    rest = gain_at_rest(frequency_Hz, response, error, shared)
    text = (
        f"gain continued to zero frequency from {raw(frequency_Hz[0], 4)} Hz and above, by ratios of "
        f"polynomials of j frequency; the reference of the others"
    )
    of_gain = max(rest.relative_error, found.at_rest)  # which is in the errors of single frequencies too
    gain_error = Uncertainty(rest.gain * of_gain, f"{_STATISTICAL} and of the fit, or a converter's steps")
    not_known = rest.undefined_because and f"response_gain is not known: {rest.undefined_because}"
    if rest.undefined_because:
        yield Measurement.undefined("response_gain", unit, text, rest.undefined_because, basis)
    else:
        yield Measurement("response_gain", rest.gain, unit, text, basis, gain_error)

    rest_dB = NEPER_DB * rest.relative_error
    relative = ResponseCurve.of_gain(frequency_Hz, response / rest.gain, error, -_HALF_POWER_DB, shared)
    text = f"lowest frequency at which the gain is 3.01 dB below response_gain, {_LOCALLY}"
    down = relative.falls_to(_HALF_POWER_DB, rest_dB)
    reason = f"it stays above up to {raw(frequency_Hz[-1], 4)} Hz"
    if not not_known and rest_dB > -_MOST_OF_THE_LEVEL * _HALF_POWER_DB:
        not_known = f"response_gain is uncertain by {raw(rest_dB, 2)} dB: play lower frequencies"
    if not_known:
        down, reason = None, not_known
    yield _frequency("bandwidth_3dB", text, down, reason, basis)

    text = f"lowest frequency at which the phase is -90 degrees, {_LOCALLY}"
    reason = f"the phase stays above up to {raw(frequency_Hz[-1], 4)} Hz"
    if rest.goes_on:
        turned, reason = None, f"it may be passed below that: {rest.undefined_because}"
    else:
        along = ResponseCurve.of_phase(frequency_Hz, response, error, -_QUARTER_TURN, shared)
        turned = along.falls_to(_QUARTER_TURN)
    yield _frequency("bandwidth_90deg", text, turned, reason, basis)

    # nowhere clearly down is not fallen; down from the first frequency on is
    has_fallen = down is not None and (math.isnan(down.standard_Hz) or not down.undefined_because)
    yield _resonance(relative, rest_dB, has_fallen, not_known, basis)

    bandwidth = None if down is None or down.undefined_because else down
    yield response_delay(frequency_Hz, gain, phase, error, bandwidth, basis)
    limit_Hz = float(frequency_Hz[-1]) if bandwidth is None else bandwidth.frequency_Hz

    inside = found.excited & (found.frequency_Hz >= frequency_Hz[0]) & (found.frequency_Hz <= limit_Hz)
    text = f"coherence of the excited frequencies from {raw(frequency_Hz[0], 4)} Hz to {raw(limit_Hz, 4)} Hz"
    coherence = found.coherence[inside]
    for name, which, value in (
        ("coherence_min", "least", np.min(coherence)),
        ("coherence_median", "median", np.median(coherence)),
    ):
        yield Measurement(
            name,
            float(value),
            "",
            f"{which} {text}",
            basis,
            uncertainty_reason="it is of this estimate, whose errors it describes",
            sensitivities=NO_SENSORS,
        )
    if not unit:
        yield from margins(frequency_Hz, response, error, basis, shared, loop)


def _frequency(name: str, definition: str, found: Point | None, reason: str, basis: Basis) -> Measurement:
    if found is None:
        return Measurement.undefined(name, "Hz", definition, reason, basis)
    if found.undefined_because:
        return Measurement.undefined(name, "Hz", definition, found.undefined_because, basis)
    source = f"{_STATISTICAL} and of the level, over the slope, and the length of the local fit"
    uncertainty = Uncertainty(found.standard_Hz, source)
    return Measurement(name, found.frequency_Hz, "Hz", definition, basis, uncertainty)


def _resonance(
    relative: ResponseCurve, rest_dB: float, has_fallen: bool, not_known: str, basis: Basis
) -> Measurement:
    """Return the greatest gain; undefined where errors hide it, or where it may be above the frequencies
    used."""
    last_Hz = float(relative.frequency_Hz[-1])
    text = f"greatest gain over response_gain, at least 0 dB, up to {raw(last_Hz, 4)} Hz"
    if not_known:
        return Measurement.undefined("resonance_peak", "dB", text, not_known, basis)
    peak_dB, of_peak_dB = relative.resonance()
    standard_dB = math.hypot(of_peak_dB, rest_dB)
    stands_out = peak_dB > _greatest_by_chance(len(relative.values)) * standard_dB
    reason = ""
    if not math.isfinite(standard_dB):
        reason = "the response beside its peak is not known: raise the stimulus, or play more frequencies"
    elif standard_dB > -_MOST_OF_THE_LEVEL * _HALF_POWER_DB:
        reason = f"it is uncertain by {raw(standard_dB, 2)} dB: raise the stimulus, or play more frequencies"
    elif stands_out and int(np.argmax(relative.smooth)) == 0 and peak_dB < relative.smooth[0] + standard_dB:
        reason = f"the gain falls from {raw(relative.frequency_Hz[0], 4)} Hz on, the lowest frequency used"
    elif not has_fallen and not stands_out:
        reason = f"the gain has not fallen by 3 dB up to {raw(last_Hz, 4)} Hz: a peak may be above that"
    elif not has_fallen and int(np.argmax(relative.smooth)) == len(relative.smooth) - 1:
        reason = f"the gain still rises at {raw(last_Hz, 4)} Hz, the highest frequency used"
    if reason:
        return Measurement.undefined("resonance_peak", "dB", text, reason, basis)
    peak_dB, standard_dB = above_zero(peak_dB, standard_dB)
    uncertain = Uncertainty(standard_dB, f"{_STATISTICAL}, and of response_gain")
    return Measurement("resonance_peak", peak_dB, "dB", text, basis, uncertain)


def _greatest_by_chance(count: int) -> float:
    """Return what the greatest of so many normal errors exceeds by chance, in standard deviations."""
    return NormalDist().inv_cdf(1.0 - _BY_CHANCE / count)


def _table(found: FrequencyResponse, unit: str, basis: Basis) -> Table:
    columns = (
        ("frequency_Hz", "Hz"),
        ("gain", unit),
        ("gain_dB", "dB"),
        ("phase_deg", "deg"),
        ("coherence", ""),
        ("gain_uncertainty", unit),
        ("phase_uncertainty_deg", "deg"),
        ("used", ""),
    )
    values = (
        found.frequency_Hz,
        found.gain,
        found.gain_dB,
        np.degrees(np.where(found.trusted, found.phase_rad, np.angle(found.response))),
        found.coherence,
        found.gain * found.error,
        np.degrees(found.error),
        found.trusted.astype(np.float64),
    )
    definition = (
        "frequency response; used is 1 where the input has power and the coherence, by the mean of "
        f"neighbouring gains, is {raw(found.least_coherence, 2)} or more; phase is without jumps from one "
        "such frequency to the next"
    )
    rows = tuple(tuple(float(cell) for cell in row) for row in np.stack(values, axis=1))
    return Table("frequency_response", definition, columns, rows, replace(basis, bandwidth_Hz=None))


class ResponseSettings(Section):
    """The channel that is excited and the one that answers, and what excites the loop about them."""

    input: str = "torque_reference"
    """Channel that is excited."""
    output: str = "torque"
    """Channel that answers."""
    stimulus: str = ""
    """Channel of what excites the loop that holds the input; by default `stimulus`, where it is recorded
    and moves, else the input itself."""


def _stimulus(block: Block, settings: ResponseSettings) -> str | None:
    """Return the channel of what excites: that of the settings, or what the drive recorded of the signal that
    it played."""
    if settings.stimulus:
        return settings.stimulus
    if PLAYED in block.names and np.ptp(block.column(PLAYED)) > 0.0:
        return PLAYED
    return None


def _measure(window: Window, settings: ResponseSettings) -> Findings:
    rows = window.excitation
    found = analyze_response(
        window.block,
        settings.input,
        settings.output,
        begin_row=rows.begin_row,
        end_row=rows.end_row,
        period_rows=rows.period_rows,
        stimulus=_stimulus(window.block, settings),
    )
    return Findings(found.measurements, found.tables, found)


_BODE: Final = Drawing("bode", "Frequency response", "Frequency response: gain, phase and coherence.")

FREQUENCY_RESPONSE: Final = Analysis(
    name="frequency_response",
    title="frequency response",
    measure=_measure,
    of_spectra=True,
    quantities=(
        Quantity(
            ("response_gain",),
            UnitOf("output", over="input"),
            "gain continued to zero frequency: ratios of polynomials of `j f` with real coefficients, of up "
            "to three zeros and four poles, fitted to gain and phase at the lowest frequencies that they "
            "describe; their mean, by how well they do for the unknowns that they have. Frequencies count "
            "from the lowest where the input has more than 1 % of its greatest power and the error is at "
            "most 1 %, or three times the median of the frequencies used. Undefined where it is 3 dB off the "
            "gain at the lowest of them, or uncertain by a fifth",
        ),
        Quantity(
            ("bandwidth_3dB",),
            "Hz",
            "lowest frequency at which the gain is `response_gain / sqrt(2)`, by a parabola through as many "
            "neighbours as it describes within their errors, shortened, or between few a cubic of the "
            "reciprocal of the response; undefined where `response_gain` is uncertain by more than 0.9 dB",
            label="bandwidth",
        ),
        Quantity(
            ("bandwidth_90deg",),
            "Hz",
            "likewise, at which the phase, without jumps, is -90 degrees; undefined where the gain goes on "
            "to change below the lowest frequency",
        ),
        Quantity(
            ("resonance_peak",),
            "dB",
            "greatest gain over `response_gain`: least value of `1 / gain^2` as a parabola of `f^2` through "
            "as many neighbours as it describes within their errors, shortened, or between few the greatest "
            "of a cubic of the reciprocal of the response; without such a peak the greatest value; less what "
            "errors add on average to the greatest of several; as it is at least 0, the median of the "
            "part of its distribution that is above. Undefined where it is uncertain by more than 0.9 dB, "
            "where the gain neither shows a peak nor falls by 3 dB in the frequencies used, and where it "
            "falls from the lowest on",
        ),
        Quantity(
            ("response_delay",),
            "s",
            "`-1 / (2 pi)` x slope of the least-squares line of phase over frequency, all frequencies alike, "
            "from a tenth of `bandwidth_3dB`, or the lowest frequency used if that is higher, up to "
            "`bandwidth_3dB`; without that up to the highest used",
        ),
        Quantity(
            ("coherence_min", "coherence_median"), "", "of the excited frequencies up to `bandwidth_3dB`"
        ),
        Quantity(
            ("crossover",),
            "Hz",
            "of a response of one unit, `T`: lowest frequency at which the open loop `L = T / (1 - T)`, "
            "unity feedback, has the gain 1; read above the frequencies at which noise hides `1 - T`. Where "
            "the record shows that the input is the stimulus less the output, the response is `L`",
        ),
        Quantity(
            ("phase_margin",),
            "deg",
            "180 degrees + phase of `L` at `crossover`; none where its gain is above 1 again",
        ),
        Quantity(("gain_margin",), "dB", "gain of `L` below 1 where its phase first falls to -180 degrees"),
        Quantity(
            ("sensitivity_peak",),
            "",
            "`M_s`, greatest magnitude of `S = 1 - T`, read as `resonance_peak` is (Åström and Murray, "
            "*Feedback Systems*, 2nd ed., "
            "12.1). Undefined where it falls from the lowest frequency used on, where it is below 1, which "
            "it reaches above the frequencies used, where it has "
            "not clearly fallen at the last of them and `T` is not small there, and where it is uncertain by "
            "more than a tenth",
        ),
    ),
    settings=ResponseSettings,
    measured=Measured.ON_REQUEST,
    channel_settings=("input", "output", "stimulus"),
    figures=(_BODE,),
    comparisons=(TORQUE, _BODE),
)
