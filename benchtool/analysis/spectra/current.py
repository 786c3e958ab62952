"""Spectrum of a phase current: fundamental, distortion in its several definitions, noise."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace
from functools import partial
from typing import Final

import numpy as np

from benchtool.analysis.coherent.spectrum import (
    FIRST_ROW,
    CoherentSamples,
    CoherentSpectrum,
    harmonics,
)
from benchtool.analysis.declaration import Analysis, Drawing, Findings, NoSettings, Quantity
from benchtool.analysis.drawings import WAVEFORMS
from benchtool.analysis.measurement import Basis, Measurement, Table
from benchtool.analysis.noise.noise import NoiseFloor, noise_floor
from benchtool.analysis.noise.noise_of_periods import NoFloor, without_changes
from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.phase.mean_frequency import frequency
from benchtool.analysis.quantisation.resolution import level_of, resolution
from benchtool.analysis.spectra.distortion_with_noise import distortion_with_noise
from benchtool.analysis.spectra.distortions import distortions, group_basis, group_distortions
from benchtool.analysis.spectra.flat_crests import crest_is_flat, flat_crest, with_flat_crest
from benchtool.analysis.spectra.floor_numbers import noise_numbers
from benchtool.analysis.spectra.fundamental import fundamental_and_largest
from benchtool.analysis.spectra.groups import group_table, harmonic_groups
from benchtool.analysis.spectra.harmonics import HIGHEST_HARMONIC, harmonic_table
from benchtool.analysis.spectra.interharmonics import noise_of_fit
from benchtool.analysis.spectra.line_errors import LineErrors, line_errors
from benchtool.analysis.spectra.modulation import amplitude_changes, harmonics_tell, phase_noise_rad
from benchtool.analysis.spectra.separation import Separation, separate
from benchtool.analysis.spectra.soundness import soundness, turned_around
from benchtool.analysis.statistics.outlying_samples import clicks_among
from benchtool.analysis.validity import clipping, require_finite, require_unbroken, standing
from benchtool.analysis.window import Window
from benchtool.block import Block

_BEATS = (
    "the amplitude changes within the window, and no harmonic tells that it is no line beside the "
    "fundamental: record longer, or the angle"
)


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
        AnalysisError: a gap, no such channel, a sample that is not finite, a dead signal, fewer than two
            electrical periods, or a fundamental beyond the band.
    """
    require_unbroken(block)
    samples, unit = np.ascontiguousarray(block.column(channel)), block.unit(channel)
    require_finite(samples, channel)
    step = resolution(samples)
    found = separate(samples, block.sample_rate_Hz, track, channel, step)
    sound = soundness(found.spectrum, found.moved, _refusal(found, channel, unit), channel)
    errors = _errors(found, step)
    beats = _may_beat(found, errors, step)
    if beats:
        errors = replace(errors, wander=np.append(math.nan, errors.wander[1:]))
    basis = _basis(found.coherent, found.spectrum, found.track)
    lines = basis
    if found.taken is not None:
        lines = replace(basis, window=f"{basis.window}, without {found.taken.words}")
    groups = harmonic_groups(found.coherent, HIGHEST_HARMONIC)
    on_its_own, beside_rad = found.over_record(block.sample_rate_Hz, channel)
    of_frequency = frequency(
        found.clean if found.by_signal else found.spectrum,
        found.track,
        on_its_own,
        basis,
        rate_relative,
        sound.of_ratios or (_BEATS if beats else ""),
        step,
        beside_rad,
        partial(found.within_periods, block.sample_rate_Hz, channel),
    )
    amplitudes = fundamental_and_largest(found.spectrum, found.clean, errors, unit, channel, lines)
    ratios = (
        *distortions(found.clean, errors, lines, channel, current_rated_A_rms, unit),
        distortion_with_noise(found, errors, basis, channel),
        *group_distortions(found.coherent, found.clean, errors, groups, basis, channel, found.beside(groups)),
    )
    noise = noise_numbers(_noise(found, step), found.spectrum.fundamental_Hz, unit, channel, lines)
    others = (
        *_refused(amplitudes, sound.of_amplitudes),
        *_refused(ratios, sound.of_ratios),
        *_refused(noise, sound.of_amplitudes),
    )
    of_lines = replace(lines, harmonics=len(errors.phase))
    table = harmonic_table(found.clean, "current_harmonics", channel, unit, of_lines, errors=errors)
    why = sound.of_amplitudes
    share = flat_crest(samples, found.turns, step)
    if share and not why:
        why = crest_is_flat(share)
        others = tuple(with_flat_crest(each, share) for each in others)
    tables = [table.without_uncertainty(why) if why else table]
    if groups is not None:
        of_groups = group_basis(found.coherent, groups, basis)
        tables.append(group_table(groups, "current_groups", unit, of_groups))
    numbers = (of_frequency, *others)
    return CurrentSpectrum(numbers, tuple(tables), found.spectrum, found.track, found.coherent, share)


def _refusal(found: Separation, channel: str, unit: str) -> str:
    """Return why no number is of the current itself: it is clipped, stands still, turns around or clicks; ""
    where it is."""
    invalid = clipping(found.samples, unit) or standing(found.samples, unit)
    if not invalid and found.track.residual_rad is None:
        between = None if found.close.lines is None else found.between
        invalid = turned_around(found.cleaned, found.seen, channel, between)
    if not invalid and found.moved.jump_rad and (clicks := clicks_among(found.samples, unit)):
        return f"{clicks}: clicks, at which the phase of {channel} jumps; choose a window without them"
    return invalid


def _errors(found: Separation, step: float) -> LineErrors:
    """Return the errors of the harmonics, whose spectrum is the clean one."""
    highest = min(HIGHEST_HARMONIC, len(harmonics(found.spectrum)))
    seen, alone, others, trend = found.seen, found.alone, found.others, found.steady.trend
    jitter_rad = phase_noise_rad(found.cleaned, is_followed=found.track.departure is not None)
    errors = line_errors(
        found.clean,
        highest,
        max(alone.excess_rad, seen.undecided_rad, jitter_rad),
        step,
        alone.amplitude,
        alone.phase_rad,
        found.turns,
        level_of(found.samples, step),
        seen.of_angle,
        None if others is None else noise_of_fit(others, found.clean, highest, len(found.coherent.values)),
        None if trend is None else (found.with_course, trend.of_level),
    )
    return replace(errors, beside=found.close.standard[:highest])


def _may_beat(found: Separation, errors: LineErrors, step: float) -> bool:
    """Return whether a line beside the fundamental may be all that changes it: it has no phase but its own,
    and no harmonic tells."""
    trend = found.steady.trend
    return (
        (found.by_signal or found.track.follows_signal)
        and not found.close.turned_rad
        and amplitude_changes(found.alone.amplitude, trend, step)
        and not harmonics_tell(found.with_course, len(errors.phase))
    )


def _noise(found: Separation, step: float) -> NoiseFloor | NoFloor:
    """Return the noise floor between the harmonics, or why it is not known."""
    quiet, spectrum = found.quiet
    trend, follows_signal = found.steady.trend, found.track.follows_signal
    has_moved = found.track.departure is not None or trend is not None
    return without_changes(
        noise_floor(spectrum, has_moved=has_moved, follows_signal=follows_signal, taken=found.places),
        spectrum,
        quiet,
        has_stepped=trend is not None and trend.is_step,
        follows_signal=follows_signal,
        step=step,
    )


def _refused(measurements: Iterable[Measurement], reason: str) -> Iterator[Measurement]:
    """Yield the measurements; if there is a `reason`, as undefined by that."""
    for each in measurements:
        if reason:
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
            "phase between first and last row / (2 pi duration); without an angle, what the current does in "
            "every period alike is part of its waveform, and none of its phase",
            "of the slopes that the angle's counts allow at a constant speed, or else of the angle at both "
            "ends, by smoothing splines of any stiffness through 128 means, steps that beat with the rows, "
            "and half of what may be the rotor's or an error of its sensor: what it does in every revolution "
            "or period alike, by which these differ too, of fewer than two revolutions all that it does; of "
            "an angle that agrees with the signal's own phase both, by their variances; half of what the "
            "signal departs from it, steadily or to and fro; of the sine fit sqrt(54.5) u_q / "
            "(2 pi A_1 duration), u_q the noise "
            "beside the line in quadrature (Hann-weighted; unweighted it were sqrt(12)), under a Hann window "
            "where that is clearly less, "
            "and the converter's steps that fold to beside the line; of a phase that was followed, and of an "
            "angle of less than a revolution, or that swings within less than two, the noise at both ends of "
            "the signal's own phase, of a load that swings within few periods that within periods, and what "
            "harmonics that swing with it, and a swing twice as fast, leave there, or half of the phase of "
            "lines about the fundamental that may be its swing; of fewer than five periods the course of "
            "that angle and its slope, none within a revolution",
        ),
        Quantity(
            ("current_fundamental",),
            "A",
            "A_1, without what leaks into it from tones between the harmonics, steady or swept, and a "
            "decaying dc; of an amplitude that ramps or steps the mean over time, of one that swings for a "
            "cycle or more that about which it swings",
            "noise beside the line, with the course of the amplitude divided out, or, of one with a memory, "
            "that of its mean over periods; resampling, wander of the phase, resolution, the fit of a tone "
            "nearby, a line less than 1.5 bins away",
        ),
        Quantity(
            ("current_max_low_harmonic",),
            "A",
            "largest bin below 10 f_1 but dc and fundamental; interharmonics count, but not what leaks from "
            "them into the bins of harmonics",
            "likewise, and what the largest of n bins of noise reads, A_n sqrt(ln n), or the largest line "
            "that a converter's errors fold down to",
        ),
        Quantity(
            ("current_thd_f",),
            "%",
            "100 sqrt(max(0, A_2^2 + ... + A_H^2 - N^2)) / A_1, with N^2 the sum of A_n^2 around harmonics 2 "
            "to H and of what repeated quantisation adds to them on average: THD_F, after IEC "
            "61000-4-7:2002+A1:2008, but without the noise. Where the fundamental swings by less than half a "
            "cycle in a period, harmonics are those along its phase; by more, along the rotor's angle where "
            "the current follows that within periods, else in time: between harmonics its sidebands are "
            "interharmonics",
            "half of the longer side of sqrt(x +- 2 u), x what stands under the root, u from the noise in "
            "the harmonics, with what modulates them alike, the floor's own uncertainty and the scatter of "
            "what quantisation adds, and what averages of roots of which half are cut off at zero keep; and "
            "those of the A_k that are of type B, propagated to first order; beside sidebands on both sides "
            "of the fundamental, half of what they differ by along the angle and without it",
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
            "without the course of the amplitude, if it has one, and of a phase that moves beyond noise; "
            "what is between harmonics counts in the bins of dc and the fundamental, too",
            "scatter of that power over the electrical periods, without what is between harmonics, and what "
            "the noise in the bins around it does to that; its phases against the harmonics, one another "
            "and the record; the fundamental; where the steps of a converter fall, which are part of "
            "the noise",
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
