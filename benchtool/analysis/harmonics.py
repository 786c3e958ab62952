"""Harmonics of a coherent spectrum: their table, and the distortion they add up to."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.measurement import Basis, Table
from benchtool.analysis.noise import harmonic_noise
from benchtool.analysis.spectrum import CoherentSpectrum

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

    `standard` is the standard uncertainty of `ratio` that the noise between the harmonics gives it, to first
    order; `noise` is what that noise alone would read. All are nan where they are unknown.
    """

    ratio: float
    highest_harmonic: int
    standard: float
    noise: float


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
    `stated_amplitude` is the peak amplitude that `Reference.STATED` means.

    Raises:
        ValueError: `Reference.STATED` without `stated_amplitude`.
    """
    amplitude = harmonics(spectrum)[:highest_harmonic]
    noise = harmonic_noise(spectrum, len(amplitude))
    fundamental = float(amplitude[0])
    content = float(np.linalg.norm(amplitude[1:]))
    if content > 0.0:
        of_content = float(np.linalg.norm(amplitude[1:] * noise[1:])) / content
    else:
        of_content = float(np.mean(noise[1:])) if len(noise) > 1 else math.nan
    alone = math.sqrt(2.0) * float(np.linalg.norm(noise[1:]))
    match reference:
        case Reference.STATED:
            if stated_amplitude is None:
                raise ValueError("a stated reference needs its amplitude")
            base, standard = stated_amplitude, of_content
        case Reference.FUNDAMENTAL:
            base = fundamental
            standard = math.hypot(of_content, _ratio(content, base) * noise[0])
        case Reference.TOTAL:
            # of c / sqrt(c^2 + a^2): a^2 / r^3 by the content c, c a / r^3 by the fundamental a
            base = math.hypot(content, fundamental)
            share = _ratio(fundamental, base)
            standard = share * math.hypot(share * of_content, _ratio(content, base) * noise[0])
    return Distortion(
        _ratio(content, base), len(amplitude), float(_ratio(standard, base)), _ratio(alone, base)
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
        harmonic_noise(spectrum, len(amplitude)),
    )
    return Table(
        name,
        "amplitude: peak; phase: of the cosine when the fundamental is at its maximum; "
        "uncertainty: standard, noise floor around the harmonic / sqrt(2)",
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
