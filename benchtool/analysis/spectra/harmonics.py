"""Harmonics of a coherent spectrum: their table, and the distortion they add up to."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSpectrum, harmonics
from benchtool.analysis.measurement import Basis, LineColumn, Table
from benchtool.analysis.noise.noise import noise_floor
from benchtool.analysis.noise.noise_of_lines import contribution_of_noise
from benchtool.analysis.spectra.line_errors import LineErrors, line_errors
from benchtool.analysis.spectra.modulation import is_modulated_alike, noise_of_sum
from benchtool.analysis.statistics.magnitudes import standard_of_root
from benchtool.analysis.statistics.scatter import MeanError
from benchtool.analysis.uncertainty import Contribution, Uncertainty, combined

HIGHEST_HARMONIC = 50
_STANDS_OUT = 5.0  # standard uncertainties of an amplitude
_CLEARLY = 6.0  # a ratio of variances
_CUT_OFF = 0.5  # of the root of a standard deviation: 0.41, and what scatters about it in means of many
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

    Noise adds its power to that of the harmonics: `noise` is what it alone would read, `with_noise` the ratio
    with it. `ratio` is without that power, 0 where nothing is left, and `budget` is its uncertainty. That of
    `with_noise` by the harmonics is `of_harmonics`, and `of_fundamental` is that of the fundamental, relative
    to it, without what both have in common; nan without harmonics. All but `with_noise` are nan where the
    noise is not known.
    """

    ratio: float
    highest_harmonic: int
    noise: float
    with_noise: float
    budget: tuple[Contribution, ...]
    of_harmonics: tuple[Contribution, ...]
    of_fundamental: float

    @property
    def standard(self) -> float:
        """Standard uncertainty of `ratio`."""
        return math.sqrt(sum(each.standard**2 for each in self.budget))


@dataclass(frozen=True)
class _Content:
    """Root of the sum of squares of the harmonics, in the signal's unit, and the effect of noise on it.

    `alone` is the root of the noise's expected sum of squares, that of repeated steps included, and `left`
    what is left without it. `of_left` is the effect of noise on that, `of_lines` the uncertainty of the
    content with noise.
    """

    alone: float
    left: float
    of_left: tuple[Contribution, ...]
    of_lines: tuple[Contribution, ...]


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

    Harmonics beyond the spectrum's band do not count. The ratio is nan where the reference is zero. What
    noise and repeated steps of a converter add to the sum of squares is taken out of it: a known effect is
    corrected (JCGM 100:2008, 3.2.4). The standard uncertainty is that of each amplitude, by `errors`
    (`line_errors` of the spectrum alone), propagated to first order (5.1.2). THD_F is that of IEC
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

    with_noise, slope, by_fundamental = over(total)
    common = _in_common(spectrum, amplitude, errors, slope, by_fundamental)
    content = _content(spectrum, amplitude, errors, common)
    of_fundamental = errors.budget(0, of_ratio=True)
    if common is not None:  # the fundamental's noise is in it
        of_fundamental = tuple(each for each in of_fundamental if each.evaluation == "B")

    base = combined(of_fundamental, "") or Uncertainty(math.nan, "")
    systematic = [each for each in content.of_lines if each.evaluation == "B"]
    ratio, slope_of_left, by_base = over(content.left)
    budget = [each.scaled(slope_of_left) for each in (*content.of_left, *systematic)]
    if by_base:
        budget.append(Contribution("fundamental", "A", by_base * base.standard, base.dof))
    return Distortion(
        ratio=ratio,
        highest_harmonic=len(amplitude),
        noise=over(content.alone)[0],
        with_noise=with_noise,
        budget=tuple(budget),
        of_harmonics=tuple(each.scaled(slope) for each in content.of_lines),
        of_fundamental=_ratio(base.standard, fundamental) if total > 0.0 else math.nan,
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
    left2 = max(0.0, measured**2 - alone2) if math.isfinite(alone2) else math.nan

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
        math.sqrt(alone2),
        math.sqrt(left2),
        _of_root(left2, deviation),
        tuple(each for each in budget if each.standard != 0.0),
    )


def _of_root(square: float, deviation: float) -> tuple[Contribution, ...]:
    """Return the uncertainty of the root of a square, at least 0, whose standard deviation is known.

    Of a signal that has none, half of the squares are cut off at zero: the roots are 0.41 times the root of
    the standard deviation on average, which the mean of many records keeps.
    """
    name = "noise in the harmonics and the floor"
    if not (math.isfinite(square) and math.isfinite(deviation)):
        return (Contribution(name, "A", math.nan),)
    standard = standard_of_root(square, deviation)
    if square > 2.0 * deviation or not deviation:
        return (Contribution(name, "A", standard),)
    cut_off = min(standard, _CUT_OFF * math.sqrt(deviation))
    return (
        Contribution(name, "A", math.sqrt(standard**2 - cut_off**2)),
        Contribution("power below zero that is cut off", "B", cut_off),
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
