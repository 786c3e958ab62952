"""Spectrum of a phase current: fundamental, distortion in its several definitions, noise."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np

from benchtool.analysis.groups import (
    PERIODS_PER_WINDOW,
    GroupDistortion,
    HarmonicGroups,
    group_distortion,
    group_table,
    harmonic_groups,
)
from benchtool.analysis.harmonics import (
    HIGHEST_HARMONIC,
    Distortion,
    Reference,
    distortion_and_noise,
    harmonic_table,
    total_harmonic_distortion,
)
from benchtool.analysis.measurement import Basis, Measurement, Table
from benchtool.analysis.noise import NoiseFloor, harmonic_noise, noise_floor
from benchtool.analysis.periods import PhaseTrack
from benchtool.analysis.spectrum import (
    FIRST_ROW,
    CoherentSamples,
    CoherentSpectrum,
    coherent_samples,
    largest_low_component,
    resampling_error,
    spectrum_of,
)
from benchtool.analysis.uncertainty import Uncertainty
from benchtool.analysis.validity import require_unbroken
from benchtool.block import Block

_LOW_ORDER = 10


@dataclass(frozen=True)
class CurrentSpectrum:
    """Result of `current_spectrum`; `spectrum` is in A peak."""

    measurements: tuple[Measurement, ...]
    tables: tuple[Table, ...]
    spectrum: CoherentSpectrum


def current_spectrum(
    block: Block,
    channel: str,
    track: PhaseTrack,
    *,
    current_rated_A_rms: float | None = None,
    rate_relative: float | None = None,
) -> CurrentSpectrum:
    """Fundamental, harmonics, distortion and noise of one ac current, in A.

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
    coherent = coherent_samples(samples, block.sample_rate_Hz, track, channel)
    spectrum = spectrum_of(coherent)
    basis = _basis(coherent, spectrum, track)
    floor = noise_floor(spectrum)
    groups = harmonic_groups(coherent, HIGHEST_HARMONIC)
    measurements = (
        _frequency(spectrum, track, floor, basis, rate_relative),
        *_lines(spectrum, unit, basis),
        *_distortions(spectrum, basis, current_rated_A_rms, unit),
        *_group_distortions(coherent, groups, basis),
        *_noise(floor, unit, basis),
    )
    highest = min(HIGHEST_HARMONIC, len(spectrum.harmonic_phase_rad))
    tables = [harmonic_table(spectrum, "current_harmonics", unit, replace(basis, harmonics=highest))]
    if groups is not None:
        tables.append(group_table(groups, "current_groups", unit, _group_basis(coherent, groups, basis)))
    return CurrentSpectrum(measurements, tuple(tables), spectrum)


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


def _frequency(
    spectrum: CoherentSpectrum,
    track: PhaseTrack,
    floor: NoiseFloor | None,
    basis: Basis,
    rate_relative: float | None,
) -> Measurement:
    turns, uncertain = 2 * math.pi * spectrum.duration_s, None
    clock = "; the clock is left out" if rate_relative is None else ", and of the rate by the time stamps"
    fundamental = float(spectrum.amplitude[spectrum.periods])
    if track.residual_rad is not None:
        uncertain = Uncertainty(
            math.sqrt(2.0) * track.residual_rad / turns,
            f"rms deviation of the angle from the fit, at both ends{clock}",
        )
    elif floor is not None and fundamental > 0.0:
        # variance of omega 24 sigma^2 / (A^2 n^3), with sigma^2 = n floor^2 / 4
        uncertain = Uncertainty(
            math.sqrt(6.0) * floor.amplitude / (fundamental * turns),
            f"noise floor by the Cramér-Rao bound (Rife and Boorstyn 1974){clock}",
        )
    if rate_relative is not None and uncertain is not None:
        of_rate = rate_relative * spectrum.fundamental_Hz
        uncertain = Uncertainty(math.hypot(uncertain.standard, of_rate), uncertain.source)
    text = "mean electrical frequency of the window"
    return Measurement("fundamental_frequency", spectrum.fundamental_Hz, "Hz", text, basis, uncertain)


def _lines(spectrum: CoherentSpectrum, unit: str, basis: Basis) -> Iterator[Measurement]:
    periods, f_1 = spectrum.periods, spectrum.fundamental_Hz
    source = "noise floor around the fundamental / sqrt(2), and the resampling; the sensor's gain is left out"
    text = f"peak amplitude at {f_1:.6g} Hz"
    amplitude, noise = float(spectrum.amplitude[periods]), float(harmonic_noise(spectrum, 1)[0])
    standard = math.hypot(noise, resampling_error(amplitude, amplitude))
    yield Measurement("current_fundamental", amplitude, unit, text, basis, _uncertain(standard, source))

    largest = largest_low_component(spectrum, _LOW_ORDER)
    limit_Hz = min(_LOW_ORDER * f_1, float(spectrum.frequency_Hz[-1]))
    text = (
        f"largest peak amplitude below {limit_Hz:.6g} Hz other than dc and the fundamental, here at "
        f"{largest.frequency_Hz:.6g} Hz; all bins, {f_1 / periods:.4g} Hz apart"
    )
    floor = noise_floor(spectrum, 0, _LOW_ORDER)
    noise = math.nan if floor is None else floor.standard
    standard = math.hypot(noise, resampling_error(largest.amplitude, amplitude))
    uncertain = _uncertain(standard, f"noise floor below {limit_Hz:.6g} Hz / sqrt(2), and the resampling")
    low = replace(basis, bandwidth_Hz=limit_Hz)
    yield Measurement("current_max_low_harmonic", largest.amplitude, unit, text, low, uncertain)


def _distortions(
    spectrum: CoherentSpectrum, basis: Basis, current_rated_A_rms: float | None, unit: str
) -> Iterator[Measurement]:
    bases = [
        ("current_thd", Reference.FUNDAMENTAL, 0.0, "fundamental"),
        ("current_thd_r", Reference.TOTAL, 0.0, Reference.TOTAL.value),
    ]
    if current_rated_A_rms is not None:
        rated, peak = (
            f"rated current of {current_rated_A_rms:g} {unit} rms",
            math.sqrt(2.0) * current_rated_A_rms,
        )
        bases.append(("current_tdd", Reference.STATED, peak, rated))
    for name, reference, stated, base in bases:
        distortion = total_harmonic_distortion(spectrum, HIGHEST_HARMONIC, reference, stated)
        last = distortion.highest_harmonic
        text = f"100 x root of the sum of squares of harmonics 2 to {last} / {base}"
        to_last = replace(basis, bandwidth_Hz=last * spectrum.fundamental_Hz, harmonics=last, reference=base)
        if last < 2 or math.isnan(distortion.ratio):
            reason = "no harmonic is within the band" if last < 2 else f"the {base} is zero"
            yield Measurement.undefined(name, "%", text, reason, to_last)
            continue
        source = (
            f"noise floor around each harmonic, which alone would read {100 * distortion.noise:.2g} %, "
            f"the {100 * distortion.bias:.2g} % that it adds, and the resampling"
        )
        at_most = "; at most: less than twice what noise alone reads" if distortion.is_upper_bound else ""
        uncertain = _uncertain(100.0 * distortion.standard, source)
        yield Measurement(name, 100.0 * distortion.ratio, "%", text + at_most, to_last, uncertain)
        if reference is Reference.FUNDAMENTAL:
            yield _corrected(distortion, last, to_last)

    yield from _with_noise(spectrum, basis)


def _corrected(distortion: Distortion, last: int, basis: Basis) -> Measurement:
    name = "current_thd_corrected"
    text = (
        f"100 x root of (sum of squares of harmonics 2 to {last} - what the noise floor around them adds to "
        f"it), at least 0, / fundamental"
    )
    if math.isnan(distortion.corrected):
        reason = "fewer than 8 bins are between harmonics"
        return Measurement.undefined(name, "%", text, reason, basis)
    source = "scatter of the noise in the harmonics, and of the floor that is taken out"
    uncertain = _uncertain(100.0 * distortion.corrected_standard, source)
    return Measurement(name, 100.0 * distortion.corrected, "%", text, basis, uncertain)


def _with_noise(spectrum: CoherentSpectrum, basis: Basis) -> Iterator[Measurement]:
    value = 100.0 * distortion_and_noise(spectrum)
    text = "100 x rms of all in the band but dc and the fundamental, noise included / fundamental"
    to_end = replace(basis, reference="fundamental")
    if math.isnan(value):
        yield Measurement.undefined("current_thd_n", "%", text, "the fundamental is zero", to_end)
    else:
        yield Measurement("current_thd_n", value, "%", text, to_end)


def _group_distortions(
    coherent: CoherentSamples, groups: HarmonicGroups | None, basis: Basis
) -> Iterator[Measurement]:
    for name, kind in (("current_thdg", "group"), ("current_thds", "subgroup")):
        base = f"{kind} of order 1"
        if groups is None:
            text = f"100 x rms of harmonic {kind}s of order 2 and above / {base}, after IEC 61000-4-7"
            reason = "four periods, and two harmonics in the band, are needed"
            yield Measurement.undefined(name, "%", text, reason, replace(basis, reference=base))
            continue
        squares = groups.group2 if kind == "group" else groups.subgroup2
        value: GroupDistortion = group_distortion(squares)
        text = f"100 x rms of harmonic {kind}s of order 2 to {groups.orders} / {base}, after IEC 61000-4-7"
        if groups.periods_per_window < PERIODS_PER_WINDOW:
            text += (
                f", over the {groups.periods_per_window} periods there are in place of {PERIODS_PER_WINDOW}"
            )
        own = replace(_group_basis(coherent, groups, basis), reference=base)
        if math.isnan(value.ratio):
            yield Measurement.undefined(name, "%", text, "order 1 is zero, or alone in the band", own)
        else:
            source = f"scatter over {groups.windows} windows"
            uncertain = _uncertain(100.0 * value.standard, source)
            yield Measurement(name, 100.0 * value.ratio, "%", text, own, uncertain)


def _group_basis(coherent: CoherentSamples, groups: HarmonicGroups, basis: Basis) -> Basis:
    periods = groups.windows * groups.periods_per_window
    return replace(
        basis,
        samples=coherent.samples * periods / coherent.periods,
        duration_s=periods / coherent.fundamental_Hz,
        bandwidth_Hz=(groups.orders + 1) * coherent.fundamental_Hz,
        window=f"rectangular, {groups.periods_per_window} whole periods; {_over(groups.windows)}",
        harmonics=groups.orders,
    )


def _over(windows: int) -> str:
    return "one of them" if windows == 1 else f"rms over {windows} of them"


def _noise(floor: NoiseFloor | None, unit: str, basis: Basis) -> Iterator[Measurement]:
    which = "bins between the harmonics, from their median / 0.8326 (Rayleigh)"
    names = (
        ("current_noise_floor", unit, f"rms over the peak amplitudes of the {which}"),
        ("current_noise_density", f"{unit}/sqrt(Hz)", f"rms per root of the width of a bin, of the {which}"),
    )
    for name, of, text in names:
        if floor is None:
            yield Measurement.undefined(name, of, text, "fewer than 8 bins are between harmonics", basis)
            continue
        value = floor.amplitude if name == "current_noise_floor" else floor.density
        uncertain = Uncertainty(value * floor.relative_error, f"median of {floor.bins} bins, white noise")
        yield Measurement(name, value, of, text, basis, uncertain)


def _uncertain(standard: float, source: str) -> Uncertainty | None:
    return Uncertainty(standard, source) if math.isfinite(standard) else None
