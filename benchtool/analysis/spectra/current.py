"""Spectrum of a phase current: fundamental, distortion in its several definitions, noise."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from typing import Final

import numpy as np

from benchtool.analysis.coherent.spectrum import (
    FIRST_ROW,
    CoherentSamples,
    CoherentSpectrum,
    Component,
    harmonics,
    largest_low_component,
    spectrum_of,
)
from benchtool.analysis.declaration import Analysis, Drawing, Findings, NoSettings, Quantity
from benchtool.analysis.drawings import WAVEFORMS
from benchtool.analysis.measurement import Basis, Measurement, Table
from benchtool.analysis.noise.converter_lines import largest_of_steps
from benchtool.analysis.noise.noise import NoiseFloor, noise_floor
from benchtool.analysis.noise.noise_of_lines import contribution_of_noise, line_noise
from benchtool.analysis.noise.noise_of_periods import without_changes
from benchtool.analysis.numbers import raw
from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.phase.mean_frequency import frequency
from benchtool.analysis.quantisation.resolution import level_of, resolution
from benchtool.analysis.sensitivity import Largest, Noise, Sensitivities, Sensitivity
from benchtool.analysis.spectra.distortion_with_noise import distortion_with_noise
from benchtool.analysis.spectra.distortions import distortions, group_basis, group_distortions
from benchtool.analysis.spectra.flat_crests import crest_is_flat, flat_crest, with_flat_crest
from benchtool.analysis.spectra.groups import group_table, harmonic_groups
from benchtool.analysis.spectra.harmonics import HIGHEST_HARMONIC, harmonic_table
from benchtool.analysis.spectra.interharmonics import noise_of_fit
from benchtool.analysis.spectra.line_errors import LineErrors, line_errors
from benchtool.analysis.spectra.modulation import amplitude_changes, harmonics_tell, phase_noise_rad
from benchtool.analysis.spectra.separation import Separation, separate
from benchtool.analysis.spectra.soundness import soundness, turned_around
from benchtool.analysis.statistics.outlying_samples import clicks_among
from benchtool.analysis.statistics.scatter import TOO_SLOW
from benchtool.analysis.uncertainty import Contribution, Uncertainty, combined_by_names
from benchtool.analysis.validity import clipping, require_unbroken, standing
from benchtool.analysis.window import Window
from benchtool.block import Block

_LOW_ORDER = 10
_BEATS = (
    "the amplitude changes within the window, and no harmonic tells that it is no line beside the "
    "fundamental: record longer, or the angle"
)
_NO_FLOOR = "fewer than 8 bins are between harmonics, or few periods in which these change: record longer"


@dataclass(frozen=True)
class CurrentSpectrum:
    """Result of `current_spectrum`; `spectrum`, of `coherent`, is in A peak, along `track`, which follows the
    fundamental. For the share `flat_crest` of a period the current stays level at a crest.
    """

    measurements: tuple[Measurement, ...]
    tables: tuple[Table, ...]
    spectrum: CoherentSpectrum
    track: PhaseTrack
    coherent: CoherentSamples
    flat_crest: float


def current_spectrum(
    block: Block,
    channel: str,
    track: PhaseTrack,
    *,
    current_rated_A_rms: float | None = None,
    rate_relative: float | None = None,
) -> CurrentSpectrum:
    """Return the fundamental, harmonics, distortion and noise of one ac current, in A.

    Args:
        block: rows without gaps, of any uniform rate.
        channel: the current; its unit is that of the results.
        track: its electrical phase over the rows, by `track_angle` or `track_tone`.
        current_rated_A_rms: the base of `current_tdd`, which is left out without it.
        rate_relative: standard uncertainty of the sample rate, relative to it, where it is known; it is then
            part of the frequency's.

    Raises:
        AnalysisError: a gap, no such channel, a dead signal, fewer than two electrical periods, or a
            fundamental beyond the band.
    """
    require_unbroken(block)
    samples, unit = np.ascontiguousarray(block.column(channel)), block.unit(channel)
    step = resolution(samples)
    found = separate(samples, block.sample_rate_Hz, track, channel, step)
    track, spectrum = found.track, found.spectrum
    basis = _basis(found.coherent, spectrum, track)
    invalid = clipping(samples, unit) or standing(samples, unit)
    if not invalid and track.residual_rad is None:
        invalid = turned_around(
            found.cleaned, found.seen, channel, None if found.close.lines is None else found.between
        )
    if not invalid and found.seen.jump_rad and (clicks := clicks_among(samples, unit)):
        invalid = f"{clicks}: clicks, at which the phase of {channel} jumps; choose a window without them"
    sound = soundness(spectrum, found.seen, invalid, channel)
    clean, with_trend = found.clean, None
    if found.steady.trend is not None:
        with_trend = spectrum_of(found.cleaned), found.steady.trend.of_level
    errors = _errors(found, clean, with_trend, step)
    of_steps = largest_of_steps(clean, errors.steps, _LOW_ORDER)
    # with no phase but its own, and no harmonic that tells, a line beside it may be all that changes
    beats = (
        (found.by_signal or found.track.follows_signal)
        and not found.close.turned_rad
        and amplitude_changes(found.alone.amplitude, found.steady.trend, step)
        and not harmonics_tell(clean if with_trend is None else with_trend[0], len(errors.phase))
    )
    if beats:
        errors = replace(errors, wander=np.append(math.nan, errors.wander[1:]))
    has_moved = found.track.departure is not None or found.steady.trend is not None
    lines, taken = basis, found.taken
    if taken is not None:
        lines = replace(basis, window=f"{basis.window}, without {taken.words}")
    quiet, spectrum_of_quiet = found.quiet
    floor = without_changes(
        noise_floor(spectrum_of_quiet, has_moved=has_moved, follows_signal=found.track.follows_signal),
        spectrum_of_quiet,
        quiet,
        has_stepped=found.steady.trend is not None and found.steady.trend.is_step,
        follows_signal=found.track.follows_signal,
        step=step,
    )
    groups = harmonic_groups(found.coherent, HIGHEST_HARMONIC)
    beside = None if groups is None else found.beside(clean, groups)
    on_its_own, beside_rad = found.over_record(block.sample_rate_Hz, channel)
    numbers = (
        frequency(
            clean if found.by_signal else spectrum,
            track,
            on_its_own,
            basis,
            rate_relative,
            sound.of_ratios or (_BEATS if beats else ""),
            step,
            beside_rad,
        ),
        *_refused(_lines(spectrum, clean, errors, of_steps, unit, channel, lines), sound.of_amplitudes),
        *_refused(distortions(clean, errors, lines, channel, current_rated_A_rms, unit), sound.of_ratios),
        *_refused(
            [
                distortion_with_noise(
                    found.whole, found.steady.samples, found.components, errors, basis, channel
                )
            ],
            sound.of_ratios,
        ),
        *_refused(
            group_distortions(found.coherent, clean, errors, groups, basis, channel, beside), sound.of_ratios
        ),
        *_refused(
            _noise(floor, spectrum.fundamental_Hz, unit, channel, lines),
            sound.of_amplitudes,
        ),
    )
    of_lines = replace(lines, harmonics=len(errors.phase))
    table = harmonic_table(clean, "current_harmonics", channel, unit, of_lines, errors=errors)
    why = sound.of_amplitudes
    share = flat_crest(samples, found.turns, step)
    if share and not why:
        why = crest_is_flat(share)
        numbers = (numbers[0], *(with_flat_crest(each, share) for each in numbers[1:]))
    tables = [table.without_uncertainty(why) if why else table]
    if groups is not None:
        of_groups = group_basis(found.coherent, groups, basis)
        tables.append(group_table(groups, "current_groups", unit, of_groups))
    return CurrentSpectrum(numbers, tuple(tables), spectrum, track, found.coherent, share)


def _errors(
    found: Separation,
    clean: CoherentSpectrum,
    with_trend: tuple[CoherentSpectrum, float] | None,
    step: float,
) -> LineErrors:
    """Return the errors of the harmonics, whose spectrum is `clean`; `with_trend` as in `line_errors`."""
    highest = min(HIGHEST_HARMONIC, len(harmonics(found.spectrum)))
    seen, alone, others = found.seen, found.alone, found.others
    errors = line_errors(
        clean,
        highest,
        max(alone.excess_rad, seen.undecided_rad, phase_noise_rad(found.cleaned)),
        step,
        alone.amplitude,
        alone.phase_rad,
        found.turns,
        level_of(found.samples, step),
        seen.of_angle,
        None if others is None else noise_of_fit(others, clean, highest, len(found.coherent.values)),
        with_trend,
    )
    return replace(errors, beside=found.close.standard[:highest])


def _refused(measurements: Iterable[Measurement], reason: str) -> Iterator[Measurement]:
    """Yield the measurements; if there is a `reason`, as undefined."""
    for each in measurements:
        if reason and math.isfinite(each.value):
            yield Measurement.undefined(each.name, each.unit, each.definition, reason, each.basis)
        else:
            yield each


def _basis(coherent: CoherentSamples, spectrum: CoherentSpectrum, track: PhaseTrack) -> Basis:
    return Basis(
        samples=coherent.samples,
        sample_rate_Hz=coherent.sample_rate_Hz,
        duration_s=spectrum.duration_s,
        bandwidth_Hz=float(spectrum.frequency_Hz[-1]),
        window=f"rectangular, {coherent.periods} whole electrical periods from row {FIRST_ROW} (from 0) on, "
        f"by {track.source}, resampled to {coherent.per_period} steps of phase each",
        gaps=0,
    )


def _lines(
    spectrum: CoherentSpectrum,
    clean: CoherentSpectrum,
    errors: LineErrors,
    of_steps: float,
    unit: str,
    channel: str,
    basis: Basis,
) -> Iterator[Measurement]:
    """Yield the fundamental and the largest low line; `of_steps` is how large one by a converter may be."""
    periods, f_1 = spectrum.periods, spectrum.fundamental_Hz
    text = f"peak amplitude at {raw(f_1, 6)} Hz"
    own = combined_by_names(errors.budget(0))
    why = "" if own is not None else errors.unknown
    line = replace(basis, frequency_Hz=f_1)
    yield Measurement(
        "current_fundamental",
        clean.fundamental,
        unit,
        text,
        line,
        own,
        uncertainty_reason=why,
        sensitivities=Sensitivities.of_line(channel, clean.fundamental),
    )

    # a line beside a harmonic, or an amplitude that wanders, is in the harmonic's bin and not in the harmonic
    read = spectrum.amplitude.copy()
    read[::periods] = clean.amplitude[::periods]
    largest = largest_low_component(replace(spectrum, amplitude=read), _LOW_ORDER)
    limit_Hz = min(_LOW_ORDER * f_1, float(spectrum.frequency_Hz[-1]))
    text = (
        f"largest peak amplitude below {raw(limit_Hz, 6)} Hz other than dc and the fundamental, here at "
        f"{raw(largest.frequency_Hz, 6)} Hz; all bins, {raw(f_1 / periods, 4)} Hz apart"
    )
    low = replace(basis, bandwidth_Hz=limit_Hz, frequency_Hz=largest.frequency_Hz)
    place = round(largest.frequency_Hz / spectrum.frequency_Hz[1])
    uncertain = _of_largest(clean if place % periods == 0 else spectrum, largest, errors, of_steps)
    why = "" if uncertain is not None else f"the noise around {raw(largest.frequency_Hz, 4)} Hz is not known"
    yield Measurement(
        "current_max_low_harmonic",
        largest.amplitude,
        unit,
        text,
        low,
        uncertain,
        uncertainty_reason=why,
        sensitivities=Sensitivities((Sensitivity(channel, largest.amplitude),), Largest(f_1)),
    )


def _of_largest(
    spectrum: CoherentSpectrum, largest: Component, errors: LineErrors, of_steps: float
) -> Uncertainty | None:
    """Return the uncertainty of the largest of n bins, where noise alone reads the floor times sqrt(ln n),
    and a converter alone up to `of_steps`."""
    place = round(largest.frequency_Hz / spectrum.frequency_Hz[1])
    order = place / spectrum.periods
    floor = noise_floor(spectrum, 0, _LOW_ORDER)
    alone2 = math.nan if floor is None else floor.amplitude**2 * math.log(_LOW_ORDER * spectrum.periods)
    alone2 += of_steps**2
    bias = largest.amplitude - math.sqrt(max(0.0, largest.amplitude**2 - alone2))
    of_many = Contribution("largest of many bins of noise, or of lines by a converter", "B", bias)
    nearest = min(max(round(order), 1), len(errors.phase)) - 1
    if place == (nearest + 1) * spectrum.periods:
        return combined_by_names((*errors.budget(nearest), of_many))
    noise = line_noise(spectrum, np.array([place]))
    around = math.hypot(*(float(each[nearest]) for each in (errors.phase, errors.resolution, errors.fit)))
    lines = (
        contribution_of_noise(
            "noise and leakage beside the line", float(noise.in_phase[0]), float(noise.dof[0])
        ),
        of_many,
        Contribution("resampling", "B", spectrum.resampling_error(largest.amplitude, order)),
        Contribution("wander of the phase, resolution, tones nearby", "B", around),
    )
    return combined_by_names(lines)


def _noise(
    floor: NoiseFloor | None, fundamental_Hz: float, unit: str, channel: str, basis: Basis
) -> Iterator[Measurement]:
    which = (
        "bins between the harmonics, from the medians of bands of them / 0.8326 (Rayleigh), or where the "
        "density is steep the means of their squares"
    )
    names = (
        ("current_noise_floor", unit, f"rms over the peak amplitudes of the {which}"),
        ("current_noise_density", f"{unit}/sqrt(Hz)", f"rms per root of the width of a bin, of the {which}"),
    )
    for name, of, text in names:
        if floor is None:
            yield Measurement.undefined(name, of, text, _NO_FLOOR, basis)
            continue
        of_bins = name == "current_noise_floor"
        value = floor.amplitude if of_bins else floor.density
        of_bins_alone = Contribution(
            f"scatter of {floor.bins} bins in bands, and what the lines' motion may leave in them",
            "A",
            value * floor.relative_error,
            floor.dof,
        )
        changes = floor.by_time.line("change of its level with time", value)
        uncertain = combined_by_names((of_bins_alone, *([changes] if changes.standard != 0.0 else [])))
        yield Measurement(
            name,
            value,
            of,
            text,
            replace(basis, bin_Hz=floor.bin_Hz) if of_bins else basis,
            uncertain,
            uncertainty_reason="" if uncertain is not None else TOO_SLOW,
            sensitivities=Sensitivities((Sensitivity(channel, value),), Noise(fundamental_Hz)),
        )


def current_of(window: Window) -> CurrentSpectrum:
    """Return the spectrum of i_a, which other analyses share: `window.cached(current_of)`."""
    assert window.track is not None  # i_a alone gives one
    return current_spectrum(window.block, "i_a", window.track, current_rated_A_rms=window.current_rated_A_rms)


def _measure(window: Window, _: NoSettings) -> Findings:
    found = window.cached(current_of)
    return Findings(found.measurements, found.tables, found.spectrum)


CURRENT_SPECTRUM: Final = Analysis(
    name="current_spectrum",
    title="current spectrum",
    measure=_measure,
    quantities=(
        Quantity(
            ("fundamental_frequency",),
            "Hz",
            "phase between first and last row / (2 pi duration)",
            "of the slopes that the angle's counts allow at a constant speed, or else of the angle at both "
            "ends, by smoothing splines of any stiffness through 128 means, steps that beat with the rows, "
            "and half of what may be the rotor's or an error of its sensor: what it does in every revolution "
            "or period alike, of fewer than two revolutions all that it does; of an angle in counts that "
            "agrees with the signal's own phase both, by their variances; half of what the signal "
            "departs from it steadily; of the sine fit sqrt(54.5) u_q / (2 pi A_1 duration), u_q the noise "
            "beside the line in quadrature (Hann-weighted; unweighted it were sqrt(12)), under a Hann window "
            "where that is clearly less, "
            "and the converter's steps that fold to beside the line; of a phase that was followed, and of an "
            "angle of less than a revolution, or that swings within less than two, the noise at both ends of "
            "the signal's own phase (none of fewer than five periods)",
        ),
        Quantity(
            ("current_fundamental",),
            "A",
            "A_1, without what leaks into it from tones between the harmonics, steady or swept, and a "
            "decaying dc; of an amplitude that ramps, steps or swings the mean over time",
            "noise beside the line, with the course of the amplitude divided out, or, of one with a memory, "
            "that of its mean over periods; resampling, wander of the phase, resolution, the fit of a tone "
            "nearby, a line less than 1.5 bins away",
        ),
        Quantity(
            ("current_max_low_harmonic",),
            "A",
            "largest bin below 10 f_1 but dc and fundamental; interharmonics count",
            "likewise, and what the largest of n bins of noise reads, A_n sqrt(ln n), or the largest line "
            "that a converter's errors fold down to",
        ),
        Quantity(
            ("current_thd_f",),
            "%",
            "100 sqrt(max(0, A_2^2 + ... + A_H^2 - N^2)) / A_1, with N^2 the sum of A_n^2 around harmonics 2 "
            "to H and of what repeated quantisation adds to them on average: THD_F, after IEC "
            "61000-4-7:2002+A1:2008, but without the noise",
            "half of the longer side of sqrt(x +- 2 u), x what stands under the root, u from the noise in "
            "the harmonics, with what modulates them alike, the floor's own uncertainty and the scatter of "
            "what quantisation adds, and what averages of roots of which half are cut off at zero keep; and "
            "those of the A_k that are of type B, propagated to first order",
            headline=True,
        ),
        Quantity(
            ("current_thd_r",),
            "%",
            "100 sqrt(S) / sqrt(A_1^2 + S) = THD_F / sqrt(1 + THD_F^2), S under the root of THD_F",
            "likewise",
        ),
        Quantity(
            ("current_tdd",),
            "%",
            "100 sqrt(S) / (sqrt(2) I_N); after IEEE Std 519-2022, but of one record, without the noise and "
            "with the machine's rated current as our reference",
            "likewise",
        ),
        Quantity(
            ("current_thd_f_plus_noise",),
            "%",
            "100 sqrt(sum of the squares of all bins but dc and fundamental) / A_1, up to the bandwidth; "
            "without the course of the amplitude, if it has one; what is between harmonics counts in the "
            "fundamental's bin, too",
            "scatter of that power over the electrical periods, without what is between harmonics, and what "
            "the noise in the bins around it does to that; its phases against the harmonics and one "
            "another; the fundamental; where the steps of a converter fall, which are part of the noise",
        ),
        Quantity(
            ("current_thd_f_groups",),
            "%",
            "100 sqrt(G_2^2 + ... + G_H^2) / G_1, after IEC 61000-4-7:2002+A1:2008",
            "noise in the lines, as of `current_thd_f`; power beside the lines, by its scatter over the "
            "windows and that of each bin, as two estimates of one variance unless they differ (F-test); the "
            "phase at which windows begin; what repeated quantisation adds; of what stands out between "
            "harmonics its phases, the rest then being of the groups without it",
        ),
        Quantity(
            ("current_thd_f_subgroups",),
            "%",
            "100 sqrt(S_2^2 + ... + S_H^2) / S_1, after IEC 61000-4-7:2002+A1:2008",
            "likewise",
        ),
        Quantity(
            ("current_noise_floor",),
            "A",
            "A_n: mean square over bands of the bins between harmonics, each from the median / 0.8326, or "
            "where the density is steep the mean of the squares without lines; without what is taken out of "
            "the harmonics, and sidebands that stand out; by second differences of successive periods where "
            "it changes and these have less",
            "of each band's power 1 / (ln 2 sqrt(bins)) of it, or of steep ones by how few bins hold most of "
            "it, or of differences 35 / 18 over their number; of the root, the rms of errors of a gamma "
            "distribution of that relative deviation; what a harmonic whose phase wanders leaks; where a "
            "phase was followed or the course of an amplitude divided out, what the lower bands have more "
            "than the upper half, as far as differences of periods allow it; by how much more the power of "
            "parts of the record scatters",
        ),
        Quantity(
            ("current_noise_density",), "A/sqrt(Hz)", "A_n / sqrt(2 bin width), rms per sqrt(Hz)", "likewise"
        ),
    ),
    settings=NoSettings,
    channels=("i_a",),
    figures=(
        WAVEFORMS,
        Drawing(
            "current_spectrum",
            "Spectrum of phase current a",
            "Amplitude spectrum of phase current a over whole electrical periods: above, up to ten times "
            "the fundamental, below, the whole band. Where there are more lines than dots, the least and "
            "the greatest.",
        ),
    ),
    comparisons=(
        Drawing(
            "spectra",
            "Spectra of phase current a",
            "Amplitude spectrum of phase current a up to ten times the fundamental, dc left out.",
        ),
    ),
)
