"""Lines of a spectrum without an angle: sinusoids of a signal in Hz, the largest first."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Final

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.declaration import Analysis, Findings, NoSettings, Quantity
from benchtool.analysis.lines.around_lines import BESIDE, MAIN_LOBE, Surrounded, surrounded
from benchtool.analysis.lines.drifting_lines import drifting_line
from benchtool.analysis.lines.line_course import along_course
from benchtool.analysis.lines.line_numbers import LISTED, STANDS_OUT, LinesOf, SpectralLines
from benchtool.analysis.lines.quantised_lines import HANN_POWER, steps_in_lines
from benchtool.analysis.lines.steadiness import Line, examined
from benchtool.analysis.lines.swinging_lines import with_swing
from benchtool.analysis.measurement import Basis
from benchtool.analysis.named_after import named_after
from benchtool.analysis.numbers import raw
from benchtool.analysis.quantisation.repeated_steps import noise_beside, share_left
from benchtool.analysis.quantisation.resolution import level_of, resolution
from benchtool.analysis.spectral_window import interpolated, spectral_window
from benchtool.analysis.statistics.medians import MEDIAN_OF_RMS
from benchtool.analysis.statistics.straight_lines import without_slope
from benchtool.analysis.validity import clipping, require_signal, require_unbroken
from benchtool.analysis.window import Window
from benchtool.block import Block

Floats = NDArray[np.float64]
Complexes = NDArray[np.complex128]

_LOOKED_AT = 60
_FEWEST = 64
_LOWEST_BIN = 3  # below it the window spreads the mean
_LEAST_RESPONSE = 8.0 / (3.0 * math.pi)  # of a Hann window, halfway between two bins
_APART = 2.0  # standard uncertainties of a difference
_NEARLY, _HALF = 0.9, 0.5  # of an amplitude
_MOST_PLACES, _WHOLE = 1 << 16, 0.1


def spectral_lines(
    block: Block, channel: str, name: str = "", *, rate_relative: float = 0.0
) -> SpectralLines:
    """Return the largest sinusoids of a uniformly sampled channel, up to half the rate; no angle is needed.

    A DFT of the whole record under a Hann window; frequency and amplitude of each local maximum are
    interpolated between its two greatest bins, or fitted together with lines beside it. A line stands out
    with an amplitude above five times the rms of the noise around it (`around_lines`). Of one that decays,
    or whose frequency drifts, they are the means over the record; what no such course explains has none
    (`steadiness`). What is slower than three periods in the record is not told from a drift: where it is more
    than the largest line, the largest is not known, and neither is it where a line drifts over so many bins
    that it stands out of none (`drifting_line`). `rate_relative` is the standard uncertainty of the sample
    rate, relative to it, which is that of every frequency too. The results are named after `name`, by default
    after the channel, of omega_m after "speed".

    Raises:
        AnalysisError: a gap, no such channel, or a dead signal.
    """
    require_unbroken(block)
    samples, unit, rate_Hz = (
        np.ascontiguousarray(block.column(channel)),
        block.unit(channel),
        block.sample_rate_Hz,
    )
    require_signal(samples, channel, unit)
    count = len(samples)
    basis = Basis(
        samples=count,
        sample_rate_Hz=rate_Hz,
        duration_s=count / rate_Hz,
        bandwidth_Hz=0.5 * rate_Hz,
        window="Hann, the whole record",
        gaps=0,
    )
    record = LinesOf(samples, rate_Hz, name or named_after(channel), channel, unit, basis, rate_relative)
    if clipped := clipping(samples, unit):
        return record.without_lines(clipped)
    if count < _FEWEST:
        return record.without_lines(f"{count} samples, at least {_FEWEST} are needed for a spectrum")
    bins = _windowed(samples)
    rows = _sinusoids(samples, bins)
    drifts = _drifts(bins, rows, unit, record.width_Hz)
    if rows:
        return record.with_lines(rows, _slower(samples, unit, rows[0]) or drifts)
    if drifts:
        return record.without_lines(drifts)
    return record.without_lines("no line stands out of the noise", _least_that_stands_out(bins))


def sinusoids_of(samples: Floats) -> list[Line]:
    """Return the ten largest sinusoids of uniformly sampled values, shape (n,), the largest first; none of
    fewer than 64. Places are in bins of the whole record."""
    return [] if len(samples) < _FEWEST else _sinusoids(samples, _windowed(samples))


def _sinusoids(samples: Floats, bins: Complexes) -> list[Line]:
    """Return them by the bins of the samples under a Hann window."""
    count = len(samples)
    size, step = np.abs(bins), resolution(samples)
    is_even = step > 0.0 and _is_whole(2.0 * float(np.mean(samples) - level_of(samples, step)) / step)
    rows = [_line(bins, size, place, count, step, is_even) for place in _candidates(size)]
    rows = [each for each in rows if each.amplitude > STANDS_OUT * each.noise]
    rows = sorted(rows, key=lambda each: -each.amplitude)[:_LOOKED_AT]
    steps = steps_in_lines(samples, bins, rows, step) if rows else None
    found = _examined(bins, count, rows if steps is None else [steps.with_noise(each) for each in rows])
    found = [along_course(samples, bins, each, found[1:]) for each in found[:1]] + found[1:]
    return found if steps is None else [steps.with_errors(each, bins) for each in found]


def _examined(bins: Complexes, count: int, rows: list[Line]) -> list[Line]:
    """Return the largest lines as what they turn out to be, the largest first; those that belong to one that
    changes are part of it."""
    found: list[Line] = []
    for each in rows:
        if len(found) < LISTED and not any(abs(each.place - one.place) < one.width for one in found):
            now = examined(bins, count, each, rows)
            found.append(now if now.reason or now.width else with_swing(bins, count, now))
    return sorted(found, key=lambda each: -each.amplitude)


def _slower(samples: Floats, unit: str, largest: Line) -> str:
    """Return why a line is perhaps not the largest of samples, shape (n,): what is slower may be one, and is
    larger. A steady drift is no line."""
    size = np.abs(_windowed(without_slope(samples))[1:_LOWEST_BIN])
    if not float(np.max(size)) > _LEAST_RESPONSE * largest.amplitude:
        return ""
    least = f"{raw(float(np.max(size)), 4)} {unit}".rstrip()
    return f"a line slower than {_LOWEST_BIN} periods in the record may be larger, {least}: record longer"


def _drifts(bins: Complexes, rows: Sequence[Line], unit: str, width_Hz: float) -> str:
    """Return why the first of the `rows`, the lines that stand out of the noise, is perhaps not the largest:
    another one drifts over many bins, and is none of them."""
    line = drifting_line(bins, _LOWEST_BIN)
    if line is None or (rows and line.amplitude < _NEARLY * rows[0].amplitude):
        return ""
    within = [each.amplitude for each in rows if abs(each.place - line.place) < line.reach]
    if math.hypot(*within) > _HALF * line.amplitude:  # such as one whose phase swings, and its sidebands
        return ""
    size = f"{raw(line.amplitude, 3)} {unit}".rstrip()
    return (
        f"a line of about {size} drifts around {raw(line.place * width_Hz, 4)} Hz, over so many bins that it "
        f"stands out of none: choose a window of steady speed, or record an angle"
    )


def _least_that_stands_out(bins: Complexes) -> float:
    """Return the amplitude that no line of bins has in which none stands out: that of the greatest bin
    halfway between two, with the noise there."""
    size = np.abs(bins)
    places = _peaks(size)
    if not len(places):
        return float(np.max(size)) / _LEAST_RESPONSE
    greatest = int(places[np.argmax(size[places])])
    noise = surrounded(bins, size, greatest).noise
    return max(float(size[greatest]) + _APART * noise, STANDS_OUT * noise) / _LEAST_RESPONSE


def _windowed(samples: Floats) -> Complexes:
    """Return the peak amplitudes of samples, shape (n,), in bins of a Hann window, shape (n // 2 + 1,)."""
    weights = spectral_window("hann", len(samples))
    bins = fft.rfft((samples - np.mean(samples)) * weights) * (2.0 / float(np.sum(weights)))
    return np.asarray(bins)


def _peaks(bins: Floats) -> NDArray[np.int64]:
    """Return the local maxima, away from both ends."""
    inner = bins[1:-1]
    places = np.flatnonzero((inner > bins[:-2]) & (inner >= bins[2:])) + 1
    return places[(places >= _LOWEST_BIN) & (places < len(bins) - _LOWEST_BIN)]


def _candidates(bins: Floats) -> NDArray[np.int64]:
    """Return candidates for local maxima that stand out: all that do, and few others.

    Where the median around a maximum is below a level, a third of the bins are below it in at least one of
    the blocks, of a quarter of the bins to one side, that these bins lie in. That leaves out most maxima of a
    long record, and the medians themselves most of the rest.
    """
    places, reach, size = _peaks(bins), MAIN_LOBE + BESIDE, BESIDE // 4
    blocks = bins[: len(bins) // size * size].reshape(-1, size)
    if len(blocks) * size <= 2 * reach + 1:
        return places
    third = np.partition(blocks, size // 3, axis=1)[:, size // 3]
    within = math.ceil(reach / size)
    padded = np.pad(third, within, mode="edge")
    lowest: Floats = np.min(np.lib.stride_tricks.sliding_window_view(padded, 2 * within + 1), axis=1)
    level = STANDS_OUT / MEDIAN_OF_RMS * _LEAST_RESPONSE

    def at_end() -> NDArray[np.bool_]:
        return (places <= reach) | (places >= len(blocks) * size - reach)

    block = np.minimum(places // size, len(blocks) - 1)
    places = places[at_end() | (bins[places] > level * lowest[block])]
    beside = np.arange(MAIN_LOBE + 1, reach + 1)
    around = np.concatenate([-beside, beside])
    middle, inner = np.zeros(len(places)), ~at_end()
    middle[inner] = np.median(bins[places[inner][:, np.newaxis] + around], axis=1)
    return places[bins[places] > level * middle]


def _line(bins: Complexes, size: Floats, place: int, count: int, step: float, is_even: bool) -> Line:
    """Return a sinusoid by the two greatest bins of its maximum, with its uncertainty by noise.

    Under a Hann window neighbouring bins have noise with the correlation -2/3, and a sinusoid in them the
    opposite sign: ratio r = A_2 / A_1, offset (2 r - 1) / (1 + r), and so u(offset) =
    3 / (1 + r)^2 x u(A_1) / A_1 x sqrt(1 + r^2 - 4 r / 3).
    """
    found, own, ratio = surrounded(bins, size, place), float(size[place]), interpolated(size, place)[1]
    component = found.noise / math.sqrt(2.0)
    spread = 3.0 / (1.0 + ratio) ** 2 * math.sqrt(1.0 + ratio**2 - 4.0 * ratio / 3.0)
    of_steps, repeat = _of_steps(found, count, step, is_even) if step > 0.0 else (0.0, False)
    of_amplitude = math.hypot(component * found.amplitude / own, of_steps if repeat else 0.0)
    # steps may make a line that is less than one
    far = math.hypot(found.far, of_steps if repeat or found.amplitude < step else 0.0)
    return Line(found.place, found.amplitude, spread * component / own, of_amplitude, found.noise, far)


def _of_steps(line: Surrounded, count: int, step: float, is_even: bool) -> tuple[float, bool]:
    """Return the standard uncertainty of the amplitude of a line by what a converter's steps repeat with it,
    and whether they repeat from period to period: else they are looked up along the record.

    Errors are another from step to step that the line crosses in a period, or from sample to sample where n
    samples take so nearly a whole number of periods that the same n places are read again and again: each has
    the variance of a step, and the line 2 / n of that. Steps that lie evenly about the mean err alike, with
    the other sign, half a period later. What noise hides of a step is in its own noise.
    """
    crossed = max(1.0, 4.0 * line.amplitude / step)
    together = np.arange(1.0, max(2.0, min(crossed, float(count), _MOST_PLACES)))
    turned = together * line.place / count
    drifts = np.abs(turned - np.round(turned)) * (count / together)
    places = together * np.maximum(1.0, 2.0 * drifts * crossed)
    if is_even:  # of an odd number the other half is between the places
        places = np.where(together % 2.0 == 0.0, 0.5 * places, places)
    noise_rms = line.far * math.sqrt(count / HANN_POWER)
    hidden = share_left(noise_beside(noise_rms**2, step), step) if math.isfinite(noise_rms) else 1.0
    fewest = float(np.min(places))
    return hidden * step * math.sqrt(2.0 / (12.0 * min(crossed, fewest))), fewest < crossed


def _is_whole(number: float) -> bool:
    return abs(number - round(number)) < _WHOLE


def _measure(window: Window, _: NoSettings) -> Findings:
    lines = spectral_lines(window.block, "torque")
    return Findings(lines.measurements, lines.tables, lines)


TORQUE_LINES: Final = Analysis(
    name="torque_spectrum",
    title="torque spectrum",
    measure=_measure,
    quantities=(
        Quantity(
            ("torque_line_frequency",),
            "Hz",
            "mean frequency of the largest sinusoid, up to half the sample rate",
        ),
        Quantity(("torque_line_amplitude",), "Nm", "its mean peak amplitude, without sidebands"),
    ),
    settings=NoSettings,
    channels=("torque",),
)
