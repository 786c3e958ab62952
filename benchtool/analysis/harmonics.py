"""Harmonics of a coherent spectrum: their table, and the distortion they add up to."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.measurement import Basis, Table
from benchtool.analysis.noise import harmonic_noise, noise_floor
from benchtool.analysis.spectrum import CoherentSpectrum, resampling_error

HIGHEST_HARMONIC = 50


class Reference(Enum):
    """What the rms of the harmonics is divided by."""

    FUNDAMENTAL = "fundamental"
    """THD_F, the THD of IEC 61000-4-7."""

    TOTAL = "rms of fundamental and harmonics"
    """THD_R, never above 1."""

    STATED = "stated amplitude"
    """Total demand distortion where the amplitude is that of the rated current (IEEE Std 519)."""


@dataclass(frozen=True)
class Distortion:
    """A distortion as a ratio, from harmonics 2 to `highest_harmonic`.

    Noise adds its power to that of the harmonics, so that `ratio`, as measured, is high. `noise` is what that
    noise alone would read, `corrected` the ratio with its power taken out again (0 where nothing is left),
    `bias` how much less that is. `standard` is the standard uncertainty of `ratio`, the bias included,
    `corrected_standard` that of `corrected`. All but `ratio` are nan where the noise is unknown.
    """

    ratio: float
    highest_harmonic: int
    standard: float
    noise: float
    corrected: float
    corrected_standard: float

    @property
    def bias(self) -> float:
        return self.ratio - self.corrected

    @property
    def is_upper_bound(self) -> bool:
        """Whether the ratio is less than twice what noise alone reads, and thus says "at most"."""
        return self.ratio < 2.0 * self.noise


@dataclass(frozen=True)
class _Content:
    """Root of the sum of squares of the harmonics, in the signal's unit, and what noise does to it.

    `random` and `corrected_random` are standard uncertainties without the bias of the noise, `alone` is the
    root of the noise's expected sum of squares.
    """

    measured: float
    random: float
    alone: float
    corrected: float
    corrected_random: float


def harmonics(spectrum: CoherentSpectrum) -> NDArray[np.float64]:
    """Peak amplitudes of harmonics 1, 2, 3 ... up to the end of the band, shape (harmonics,)."""
    return spectrum.amplitude[spectrum.periods :: spectrum.periods]


def relative_phase_rad(spectrum: CoherentSpectrum) -> NDArray[np.float64]:
    """Phase of each harmonic when the fundamental, a cosine, is at its maximum, in -pi to pi.

    It does not depend on where the record begins; 0 for the fundamental itself.
    """
    order = np.arange(1, len(spectrum.harmonic_phase_rad) + 1)
    phase = spectrum.harmonic_phase_rad - order * spectrum.harmonic_phase_rad[0]
    return np.asarray(np.pi - np.mod(np.pi - phase, 2 * np.pi), dtype=np.float64)


def total_harmonic_distortion(
    spectrum: CoherentSpectrum,
    highest_harmonic: int = HIGHEST_HARMONIC,
    reference: Reference = Reference.FUNDAMENTAL,
    stated_amplitude: float | None = None,
) -> Distortion:
    """sqrt(sum over k = 2 ... H of A_k^2) over a reference, without interharmonics (after IEC 61000-4-7).

    H is `highest_harmonic` or the last one in the band; the ratio is nan if the reference is zero.
    `stated_amplitude` is the peak amplitude that `Reference.STATED` means. The noise between the harmonics
    tells what noise there is in them.

    Raises:
        ValueError: `Reference.STATED` without `stated_amplitude`.
    """
    if reference is Reference.STATED and stated_amplitude is None:
        raise ValueError("a stated reference needs its amplitude")
    amplitude = harmonics(spectrum)[:highest_harmonic]
    noise = harmonic_noise(spectrum, len(amplitude))
    fundamental, content = float(amplitude[0]), _content(spectrum, amplitude, noise)
    of_fundamental = math.hypot(noise[0], resampling_error(fundamental, fundamental))

    def over(value: float, random: float) -> tuple[float, float]:
        """Ratio of a content to the reference, and its standard uncertainty without the bias."""
        match reference:
            case Reference.STATED:
                return _ratio(value, stated_amplitude or 0.0), _ratio(random, stated_amplitude or 0.0)
            case Reference.FUNDAMENTAL:
                ratio = _ratio(value, fundamental)
                return ratio, _ratio(math.hypot(random, ratio * of_fundamental), fundamental)
            case Reference.TOTAL:
                # of c / sqrt(c^2 + a^2): a^2 / r^3 by the content c, c a / r^3 by the fundamental a
                base = math.hypot(value, fundamental)
                share = _ratio(fundamental, base)
                ratio = _ratio(value, base)
                return ratio, _ratio(share * math.hypot(share * random, ratio * of_fundamental), base)

    ratio, standard = over(content.measured, content.random)
    corrected, corrected_standard = over(content.corrected, content.corrected_random)
    return Distortion(
        ratio=ratio,
        highest_harmonic=len(amplitude),
        standard=math.hypot(standard, ratio - corrected),
        noise=over(content.alone, 0.0)[0],
        corrected=corrected,
        corrected_standard=corrected_standard,
    )


def _content(
    spectrum: CoherentSpectrum, amplitude: NDArray[np.float64], noise: NDArray[np.float64]
) -> _Content:
    """Of harmonics 2 and above; `noise` is the standard uncertainty of each amplitude.

    With a line a and noise of mean square n^2 in a bin, its square has the mean a^2 + n^2 and the variance
    2 a^2 n^2 + n^4 (noncentral chi-square of two degrees of freedom: Kendall and Stuart, vol. 2, 24.5).
    """
    square, noise2 = amplitude[1:] ** 2, 2.0 * noise[1:] ** 2
    measured, alone2 = math.sqrt(float(np.sum(square))), float(np.sum(noise2))
    if measured > 0.0:
        random = math.sqrt(float(np.sum(0.5 * square * noise2))) / measured
    else:
        random = float(np.mean(noise[1:])) if len(noise) > 1 else math.nan
    alone4 = float(np.sum(noise2**2))
    # 2 a^2 n^2 + n^4 with a^2 + n^2 as measured, and no less than without any line
    variance = max(2.0 * float(np.sum(square * noise2)) - alone4, alone4)
    floor = noise_floor(spectrum, 1.0, len(amplitude) + 1.0)
    of_floor = 2.0 * alone2 * floor.relative_error if floor is not None else math.nan
    deviation = math.hypot(math.sqrt(variance), of_floor) if math.isfinite(variance) else math.nan
    left = max(0.0, measured**2 - alone2) if math.isfinite(alone2) else math.nan
    # the root is steep at zero: half of the longer side of two deviations, so that twice it covers as many
    corrected = math.sqrt(left)
    above = math.sqrt(left + 2.0 * deviation) - corrected
    below = corrected - math.sqrt(max(0.0, left - 2.0 * deviation)) if math.isfinite(deviation) else math.nan
    resampled = resampling_error(measured, float(amplitude[0]))
    return _Content(
        measured,
        math.hypot(random, resampled),
        math.sqrt(alone2),
        corrected,
        math.hypot(0.5 * max(above, below), resampled),
    )


def distortion_and_noise(spectrum: CoherentSpectrum) -> float:
    """THD+N: rms of all bins but dc and the fundamental, over the fundamental; nan if that is zero."""
    others = float(np.sum(np.square(spectrum.amplitude[1:])))
    fundamental = float(spectrum.amplitude[spectrum.periods])
    return _ratio(math.sqrt(max(0.0, others - fundamental**2)), fundamental)


def harmonic_table(
    spectrum: CoherentSpectrum, name: str, unit: str, basis: Basis, highest_harmonic: int = HIGHEST_HARMONIC
) -> Table:
    """Harmonics 1 to `highest_harmonic` or the end of the band, one a row, with their uncertainty."""
    amplitude = harmonics(spectrum)[:highest_harmonic]
    order = np.arange(1, len(amplitude) + 1)
    percent = 100.0 * amplitude / amplitude[0] if amplitude[0] > 0.0 else np.full(len(amplitude), math.nan)
    columns = (
        order,
        spectrum.fundamental_Hz * order,
        amplitude,
        percent,
        relative_phase_rad(spectrum)[: len(amplitude)],
        np.hypot(
            harmonic_noise(spectrum, len(amplitude)),
            [resampling_error(float(each), float(amplitude[0])) for each in amplitude],
        ),
    )
    return Table(
        name,
        "amplitude: peak; phase: of the cosine when the fundamental is at its maximum; "
        "uncertainty: standard, noise floor around the harmonic / sqrt(2), and the resampling",
        (
            ("order", ""),
            ("frequency", "Hz"),
            ("amplitude", unit),
            ("percent_of_fundamental", "%"),
            ("phase", "rad"),
            ("uncertainty", unit),
        ),
        tuple(tuple(float(value) for value in row) for row in zip(*columns, strict=True)),
        basis,
    )


def _ratio(value: float, base: float) -> float:
    return value / base if base > 0.0 else math.nan
