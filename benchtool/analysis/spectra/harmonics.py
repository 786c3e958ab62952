"""Harmonics of a coherent spectrum: their table, and the distortion they add up to."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, replace
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSpectrum, harmonics
from benchtool.analysis.measurement import Basis, LineColumn, Table
from benchtool.analysis.noise.noise import noise_floor
from benchtool.analysis.noise.noise_of_lines import contribution_of_noise
from benchtool.analysis.spectra.line_errors import SURE_OF_STEPS, LineErrors, line_errors
from benchtool.analysis.spectra.modulation import is_modulated_alike, noise_of_sum
from benchtool.analysis.statistics.scatter import MeanError
from benchtool.analysis.uncertainty import Contribution, Uncertainty, combined

HIGHEST_HARMONIC = 50
_STANDS_OUT = 5.0  # standard uncertainties of an amplitude
_CLEARLY = 6.0  # a ratio of variances
_BELOW_THAT = 1.25  # noise alone reads up to 2.45 u in 95 % of records (Rayleigh)


class Reference(Enum):
    """The reference of a distortion: the divisor of the rms of the harmonics."""

    FUNDAMENTAL = "fundamental"
    """THD_F, the THD of IEC 61000-4-7:2002+A1:2008."""

    TOTAL = "rms of fundamental and harmonics"
    """THD_R, never above 1."""

    STATED = "stated amplitude"
    """Total demand distortion where the amplitude is that of the rated current (IEEE Std 519-2022)."""


@dataclass(frozen=True)
class Distortion:
    """A distortion as a ratio, from harmonics 2 to `highest_harmonic`.

    Noise adds its power to that of the harmonics, so that `ratio`, as measured, is high. `noise` is what that
    noise alone would read, `corrected` the ratio with its power taken out again (0 where nothing is left),
    `bias` how much less that is. `budget` is of `ratio`, the bias included, `corrected_budget` of
    `corrected`. All but `ratio` are nan where the noise is unknown.
    """

    ratio: float
    highest_harmonic: int
    noise: float
    corrected: float
    budget: tuple[Contribution, ...]
    corrected_budget: tuple[Contribution, ...]

    @property
    def bias(self) -> float:
        return self.ratio - self.corrected

    @property
    def standard(self) -> float:
        """Standard uncertainty of `ratio`."""
        return math.sqrt(sum(each.standard**2 for each in self.budget))

    @property
    def corrected_standard(self) -> float:
        """Standard uncertainty of `corrected`."""
        return math.sqrt(sum(each.standard**2 for each in self.corrected_budget))

    @property
    def is_upper_bound(self) -> bool:
        """Whether the ratio is less than twice what noise alone reads, and thus only an upper bound."""
        return self.ratio < 2.0 * self.noise


@dataclass(frozen=True)
class _Content:
    """Root of the sum of squares of the harmonics, in the signal's unit, and the effect of noise on it.

    `budget` is without the bias of the noise, `alone` is the root of the noise's expected sum of squares, the
    steps' included; `least` is left where the steps add two standard deviations more than expected.
    """

    measured: float
    alone: float
    corrected: float
    corrected_random: float
    least: float
    budget: tuple[Contribution, ...]


def relative_phase_rad(spectrum: CoherentSpectrum) -> NDArray[np.float64]:
    """Return the phase of each harmonic when the fundamental, a cosine, is at its maximum, in -pi to pi.

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
    errors: LineErrors | None = None,
) -> Distortion:
    """Return the THD_F, THD_R or TDD: root of the sum of squares of harmonics 2 to `highest_harmonic` over a
    reference.

    Harmonics beyond the spectrum's band do not count. The ratio is nan where the reference is zero. The
    standard uncertainty is that of each amplitude, by `errors` (`line_errors` of the spectrum alone),
    propagated to first order (JCGM 100:2008, 5.1.2), and the bias of the noise. THD_F is that of IEC
    61000-4-7:2002+A1:2008; TDD as here, of one record and with the rated current of the machine as its base,
    is a definition of this project, after IEEE Std 519-2022, whose base is the maximum demand load current at
    the point of common coupling.

    Raises:
        ValueError: `Reference.STATED` without `stated_amplitude`.
    """
    if reference is Reference.STATED and stated_amplitude is None:
        raise ValueError("a stated reference needs its amplitude")
    amplitude = harmonics(spectrum)[:highest_harmonic]
    errors = errors or line_errors(spectrum, len(amplitude))
    fundamental, total = float(amplitude[0]), math.sqrt(float(np.sum(amplitude[1:] ** 2)))

    def over(value: float) -> tuple[float, float, float]:
        """Return the ratio of a content to the reference, and its derivatives by content and fundamental."""
        match reference:
            case Reference.STATED:
                return _ratio(value, stated_amplitude or 0.0), _ratio(1.0, stated_amplitude or 0.0), 0.0
            case Reference.FUNDAMENTAL:
                ratio = _ratio(value, fundamental)
                return ratio, _ratio(1.0, fundamental), _ratio(ratio, fundamental)
            case Reference.TOTAL:
                # of c / sqrt(c^2 + a^2): a^2 / r^3 by the content c, c a / r^3 by the fundamental a
                base = math.hypot(value, fundamental)
                share, ratio = _ratio(fundamental, base), _ratio(value, base)
                return ratio, _ratio(share**2, base), _ratio(share * ratio, base)

    ratio, slope, by_fundamental = over(total)
    common = _in_common(spectrum, amplitude, errors, slope, by_fundamental)
    content = _content(spectrum, amplitude, errors, common)
    of_fundamental = errors.budget(0, of_ratio=True)
    if common is not None:  # the fundamental's noise is in it
        of_fundamental = tuple(each for each in of_fundamental if each.evaluation == "B")

    def budget(
        contributions: Iterable[Contribution], slope: float, by_fundamental: float
    ) -> list[Contribution]:
        own = [replace(each, standard=slope * each.standard) for each in contributions]
        base = combined(of_fundamental, "") or Uncertainty(math.nan, "")
        of_base = Contribution("fundamental", "A", by_fundamental * base.standard, base.dof)
        return [*own, of_base] if by_fundamental else own

    corrected, corrected_slope, corrected_by = over(content.corrected)
    least = over(content.least)[0]
    bias = Contribution("power that the noise adds", "B", ratio - least, adds_power=True)
    random = Contribution("noise in the harmonics and the floor", "A", content.corrected_random)
    systematic = [each for each in content.budget if each.evaluation == "B"]
    return Distortion(
        ratio=ratio,
        highest_harmonic=len(amplitude),
        noise=over(content.alone)[0],
        corrected=corrected,
        budget=(*budget(content.budget, slope, by_fundamental), bias),
        corrected_budget=tuple(budget([random, *systematic], corrected_slope, corrected_by)),
    )


def _in_common(
    spectrum: CoherentSpectrum,
    amplitude: NDArray[np.float64],
    errors: LineErrors,
    slope: float,
    by_fundamental: float,
) -> MeanError | None:
    """Return the noise of a ratio, by the sidebands of all its lines at once, over `slope`; None where no
    line stands out of its noise, or no pair of bins is around each.

    An amplitude that swings moves all harmonics of a current alike: that cancels in the ratio to the
    fundamental, and adds up in one to a stated amplitude. And of independent noise the sum is estimated
    once: the sum of estimates each of which allows for its few bins would allow for them many times.
    """
    total = math.sqrt(float(np.sum(amplitude[1:] ** 2)))
    stand_out = amplitude[1:] > _STANDS_OUT * errors.noise[1:]
    if not (total > 0.0 and slope > 0.0 and np.any(stand_out)):
        return None
    weights = np.concatenate([[-by_fundamental / slope], amplitude[1:] / total])
    together = noise_of_sum(spectrum, weights)
    if not by_fundamental and math.isnan(errors.wander[0]):
        return MeanError(math.nan, 1.0)
    alike = errors.had_trend or is_modulated_alike(spectrum, weights[np.newaxis, :])[0]
    if not by_fundamental and alike:
        # to a stated amplitude what they have in common adds up, of two lines by no more than chance would
        of_wander = float(np.sum(weights * errors.wander))
        return MeanError(math.hypot(together.standard, of_wander), together.dof)
    return together if math.isfinite(together.standard) else None


def _content(
    spectrum: CoherentSpectrum,
    amplitude: NDArray[np.float64],
    errors: LineErrors,
    common: MeanError | None = None,
) -> _Content:
    """Return the content of harmonics 2 and above; `common` stands for the noise beside the lines.

    With a line a and noise of mean square n^2 in a bin, its square has the mean a^2 + n^2 and the variance
    2 a^2 n^2 + n^4 (noncentral chi-square of two degrees of freedom: Kendall and Stuart, vol. 2, 24.5).
    """
    square, own2, floor2 = amplitude[1:] ** 2, errors.noise[1:] ** 2, errors.floor[1:] ** 2
    # of fifty harmonics one has by chance a few times the noise in its few pairs of bins
    noise2 = 2.0 * np.where(own2 > _CLEARLY * floor2, own2, floor2)
    repeated2, repeated2_apart = errors.power_of_steps
    measured = math.sqrt(float(np.sum(square)))
    alone2 = float(np.sum(2.0 * floor2)) + repeated2
    alone4 = float(np.sum((2.0 * floor2) ** 2))
    # 2 a^2 n^2 + n^4 with a^2 + n^2 as measured, and no less than without any line
    beside2 = 2.0 * float(np.sum(square * noise2))
    if common is not None:
        beside2 = 4.0 * (measured * common.standard) ** 2
    variance = max(beside2 - alone4, alone4)
    floor = noise_floor(spectrum, 1.0, len(amplitude) + 1.0)
    of_floor = 2.0 * alone2 * floor.relative_error if floor is not None else math.nan
    deviation = (
        math.hypot(math.sqrt(variance), of_floor, repeated2_apart) if math.isfinite(variance) else math.nan
    )
    left = max(0.0, measured**2 - alone2) if math.isfinite(alone2) else math.nan
    # the root is steep at zero: half of the longer side of two deviations, so that twice it covers as many
    corrected = math.sqrt(left)
    above = math.sqrt(left + 2.0 * deviation) - corrected
    below = corrected - math.sqrt(max(0.0, left - 2.0 * deviation)) if math.isfinite(deviation) else math.nan

    def weighted(standard: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return the share of each harmonic in an uncertainty of the content."""
        if measured > 0.0:
            return amplitude[1:] * standard[1:] / measured
        return standard[1:] / math.sqrt(max(1, len(standard) - 1))

    random = weighted(errors.noise)
    fourth = float(np.sum(random**4 / errors.dof[1:]))
    dof = float(np.sum(random**2)) ** 2 / fourth if fourth > 0.0 else math.inf
    beside = MeanError(math.sqrt(float(np.sum(random**2))), dof) if common is None else common
    by_steps, by_fit = weighted(errors.resolution), weighted(errors.fit)
    by_lines = weighted(errors.beside)
    budget = (
        contribution_of_noise("noise and leakage beside the harmonics", beside.standard, beside.dof),
        Contribution("resampling", "B", float(np.sum(weighted(errors.resampling)))),
        Contribution("wander of the phase", "B", float(np.sum(weighted(errors.phase)))),
        Contribution("resolution", "B", math.sqrt(float(np.sum(by_steps**2)))),
        Contribution("tones nearby, taken out", "B", math.sqrt(float(np.sum(by_fit**2)))),
        Contribution("lines beside the harmonics", "B", math.sqrt(float(np.sum(by_lines**2)))),
    )
    return _Content(
        measured,
        math.sqrt(alone2),
        corrected,
        0.5 * max(above, below),
        math.sqrt(max(left - SURE_OF_STEPS * repeated2_apart, 0.0)),
        tuple(each for each in budget if each.standard != 0.0),
    )


def distortion_and_noise(spectrum: CoherentSpectrum) -> float:
    """Return THD+N: rms of all bins but dc and the fundamental, over the fundamental; nan if that is zero."""
    others = float(np.sum(np.square(spectrum.amplitude[1:])))
    fundamental = float(spectrum.amplitude[spectrum.periods])
    return _ratio(math.sqrt(max(0.0, others - fundamental**2)), fundamental)


def harmonic_table(
    spectrum: CoherentSpectrum,
    name: str,
    channel: str,
    unit: str,
    basis: Basis,
    highest_harmonic: int = HIGHEST_HARMONIC,
    errors: LineErrors | None = None,
) -> Table:
    """Return harmonics 1 to `highest_harmonic` or the end of the band, one a row, with their uncertainty."""
    amplitude = harmonics(spectrum)[:highest_harmonic]
    order = np.arange(1, len(amplitude) + 1)
    percent = 100.0 * amplitude / amplitude[0] if amplitude[0] > 0.0 else np.full(len(amplitude), math.nan)
    standard = (errors or line_errors(spectrum, len(amplitude))).standard
    columns = (
        order,
        spectrum.fundamental_Hz * order,
        amplitude,
        percent,
        relative_phase_rad(spectrum)[: len(amplitude)],
        np.where(amplitude > _STANDS_OUT * standard, standard, _BELOW_THAT * standard),
    )
    return Table(
        name,
        "amplitude: peak; phase: of the cosine when the fundamental is at its maximum; uncertainty: "
        "standard, of noise and leakage beside the harmonic, resampling, wander of phase and amplitude, "
        "the fit of tones nearby, lines within a bin and a half, and resolution, "
        f"x {_BELOW_THAT:g} where noise alone may read the amplitude",
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
        lines=(LineColumn("amplitude", "uncertainty", channel, "frequency"),),
    )


def _ratio(value: float, base: float) -> float:
    return value / base if base > 0.0 else math.nan
