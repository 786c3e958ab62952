"""THD with noise: of all that is in a current but dc and its fundamental, with what makes that uncertain."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace
from typing import Final

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSpectrum, samples_of, spectrum_of
from benchtool.analysis.measurement import Basis, Measurement
from benchtool.analysis.phase.wander import Wander
from benchtool.analysis.sensitivity import Sensitivities
from benchtool.analysis.spectra.harmonics import distortion_and_noise
from benchtool.analysis.spectra.interharmonics import Interharmonics
from benchtool.analysis.spectra.line_errors import LineErrors
from benchtool.analysis.spectra.moving_tones import Course
from benchtool.analysis.spectra.separation import Separation
from benchtool.analysis.statistics.lowest_frequencies import continued_power
from benchtool.analysis.statistics.scatter import MeanError, error_of_periods, error_of_root
from benchtool.analysis.uncertainty import Contribution, Uncertainty, combined, combined_by_names

_NAME: Final = "current_thd_f_plus_noise"
_MOST = 0.9  # of the power: where the harmonics have it, their noise is what moves it
_FEW = 15.0  # degrees of freedom
_BINS_AROUND = 9
_OF_DECAY = 4.0  # bins, below which a dc that decays takes noise along when it is fitted
_LOWEST, _FINE = 8, 4  # bins that are told by places between them, and how many
_BLOCKS = 1024  # of the record, by whose means these are


def distortion_with_noise(found: Separation, errors: LineErrors, basis: Basis, channel: str) -> Measurement:
    """Return THD_F with the noise in it, of a current taken apart.

    Its power differs from period to period: that scatter is of the noise and what it does to harmonics and to
    what is between them, whose own course is no scatter, but whose phases another record has otherwise. The
    steps of a converter are noise as any other here, as in a SINAD (IEEE 1057-2017). What a fundamental whose
    phase wanders by less than is followed leaves beside its bin is as little a distortion as more of it.
    """
    spectrum, of_clean = spectrum_of(found.whole), found.clean
    amplitude = of_clean.fundamental
    text = "100 x rms of all in the band but dc and the fundamental, noise included / fundamental"
    to_end = replace(basis, reference="fundamental")
    if not (amplitude > 0.0 and spectrum.fundamental > 0.0):
        return Measurement.undefined(_NAME, "%", text, "the fundamental is zero", to_end)
    base = combined(errors.budget(0), "") or Uncertainty(math.nan, "")
    harmonic = slice(2 * spectrum.periods, None, spectrum.periods)
    # what is between harmonics leaks into the bins of the fundamental and of dc, too
    leaked = abs(spectrum.phasor[spectrum.periods] - of_clean.phasor[spectrum.periods])
    slow = _in_dc(found.taken, found.course)
    rest = math.hypot(distortion_and_noise(spectrum) * spectrum.fundamental, leaked, slow)
    rest = math.sqrt(max(0.0, rest**2 - (amplitude * _wandered_rad(found.alone)) ** 2))
    lines, value = spectrum.amplitude[harmonic], rest / amplitude
    of_phases = 0.0
    if found.taken is not None and rest > 0.0:
        of_phases = _over_phases(spectrum, of_clean, harmonic, found.taken, found.course) / rest

    def by_lines(of_lines: NDArray[np.float64]) -> float:
        """Return by how much errors of the harmonics move the amplitude of all but the fundamental."""
        moved = lines[: len(of_lines) - 1] * of_lines[1:]
        return float(np.linalg.norm(moved)) / rest if rest > 0.0 else 0.0

    by_noise, dof_of_noise = by_lines(errors.noise), float(np.max(errors.dof))
    scatter, name = _scatter_of_power(found, rest / math.sqrt(2.0)), "scatter of its power"
    are_few = math.isfinite(scatter.standard) and scatter.dof <= _FEW
    if are_few and by_noise > 0.0 and float(lines @ lines) > _MOST * rest**2:
        both = scatter.pooled_with_noise(MeanError(by_noise / math.sqrt(2.0), dof_of_noise))
        name = name if both is scatter else f"noise in the harmonics, pooled with {name}"
        scatter = both
    # the square of an amplitude is twice a mean square
    of_scatter = scatter.line(f"{name} over {spectrum.periods} electrical periods", 2**0.5)
    if by_noise > of_scatter.standard:  # few periods may agree by chance
        of_scatter = Contribution("noise in the harmonics", "A", by_noise, dof_of_noise)
    # which the ratio is to, and without which its bin counts
    of_fundamental = math.hypot(value, leaked / rest) if rest > 0.0 else value
    by_steps = by_lines(errors.resolution)
    if errors.steps is not None and rest > 0.0:
        by_steps = math.hypot(by_steps, errors.steps.of_square / rest)
    budget = [
        of_scatter.scaled(1.0 / amplitude),
        Contribution("fundamental", "A", of_fundamental / amplitude * base.standard, base.dof),
        Contribution("resolution", "B", by_steps / amplitude),
        Contribution("phases of components between the harmonics", "B", of_phases / amplitude),
    ]
    uncertain = combined_by_names(each for each in budget if each.standard != 0.0)
    return Measurement(
        _NAME,
        100.0 * value,
        "%",
        text,
        to_end,
        None if uncertain is None else uncertain.scaled(100.0),
        uncertainty_reason="" if uncertain is not None else errors.unknown,
        sensitivities=Sensitivities.of_distortion(channel, spectrum.fundamental_Hz),
    )


def _over_phases(
    spectrum: CoherentSpectrum,
    clean: CoherentSpectrum,
    harmonic: slice,
    taken: Interharmonics,
    course: Course,
) -> float:
    """Return the standard deviation of half the sum of squares of all bins over the phases of lines between
    the harmonics, against these, against one another, and against the begin of a dc that decays."""
    leaked = spectrum.phasor[harmonic] - clean.phasor[harmonic]
    squares = float(np.sum(np.abs(clean.phasor[harmonic] * leaked) ** 2))
    lines, decay = tuple(taken.components(course)), taken.decay(course)
    for one, other in itertools.combinations(lines, 2):
        squares += float(abs(np.mean(one * np.conj(other)))) ** 2
    for one in lines:  # both of its halves, at positive and negative frequency, have a product with it
        squares += float(abs(np.mean(2.0 * one * decay))) ** 2
        squares += 0.25 * float(abs(np.mean(one**2))) ** 2  # and with one another
    return math.sqrt(0.5 * squares)


def _in_dc(taken: Interharmonics | None, course: Course) -> float:
    """Return the amplitude with the power that sinusoids between the harmonics have in the bin of dc."""
    if taken is None:
        return 0.0
    return math.sqrt(2.0) * abs(sum(float(np.mean(one.real)) for one in taken.components(course)))


def _scatter_of_power(found: Separation, rms: float) -> MeanError:
    """Return the error of the `rms` of all but dc and the fundamental, by its squares in each period without
    what the periods are clean of, and by what noise does to that."""
    clean = found.steady.samples
    of_periods = samples_of(found.clean, len(clean.values)).reshape(clean.periods, -1)
    turn = 2.0 * np.pi / clean.per_period * np.arange(clean.per_period)
    phasor = found.clean.phasor[clean.periods] * _turned(found)[:, np.newaxis]
    fundamental = phasor.real * np.cos(turn) - phasor.imag * np.sin(turn)
    squares = np.mean(np.square(of_periods - fundamental), axis=1)
    error = error_of_periods(squares)
    others = found.whole.values - clean.values
    if np.any(others):
        noise = of_periods - np.mean(of_periods, axis=0)
        decays = found.taken is not None and found.taken.start != 0.0
        error = replace(error, standard=math.hypot(error.standard, _together(others, noise, decays)))
    return error_of_root(squares, rms, error)


def _wandered_rad(alone: Wander) -> float:
    """Return how far the phase of a fundamental deviates, rms, beyond its noise; 0 where it may be noise."""
    if not alone.excess_rad > 0.0:
        return 0.0
    return math.sqrt(max(0.0, float(np.var(alone.phase_rad)) - alone.noise_rad**2))


def _turned(found: Separation) -> NDArray[np.complex128]:
    """Return by what the fundamental of each period is turned, shape (periods,) or (1,) where it is not."""
    if not found.alone.excess_rad > 0.0:
        return np.ones(1, dtype=np.complex128)
    phase_rad = found.alone.phase_rad
    return np.asarray(np.exp(1j * (phase_rad - np.mean(phase_rad))))


def _together(others: NDArray[np.float64], noise: NDArray[np.float64], decays: bool) -> float:
    """Return the standard deviation of twice the mean product of `others`, shape (n,), and noise like that of
    periods, shape (periods, n / periods), whose bins are independent and as large as those around them.

    Where the others have a dc that `decays`, the noise in the lowest bins is fitted with it: there it is that
    of the bins above, continued.
    """
    power = np.abs(fft.rfft(noise.ravel())) ** 2
    between = np.arange(len(power)) % len(noise) != 0  # the mean of the periods has what is in the others
    near = np.ones(_BINS_AROUND)
    around = np.convolve(power, near, "same") / np.maximum(np.convolve(between, near, "same"), 1.0)
    products = np.abs(fft.rfft(others)) ** 2 * around / float(len(others)) ** 4
    products[0] = 0.0
    if decays:
        lowest = _lowest_products(others, noise)
        if lowest is not None:
            products[:_LOWEST] = lowest / _LOWEST
    return math.sqrt(8.0 * float(np.sum(products)))


def _lowest_products(others: NDArray[np.float64], noise: NDArray[np.float64]) -> float | None:
    """Return the sum of the products of both powers in the lowest bins, which those of noise that rises
    towards dc share: by places between them; None where too little tells its density."""
    places = (np.arange((_LOWEST - 0.5) * _FINE) + 0.5) / _FINE
    of_noise = continued_power(noise.ravel(), len(noise), _OF_DECAY, places)
    if of_noise is None:
        return None
    size = max(1, len(others) // _BLOCKS)
    blocks = len(others) // size
    means = np.mean(others[: size * blocks].reshape(blocks, size), axis=1)
    turns = np.exp(-2j * np.pi / len(others) * size * np.outer(places, np.arange(blocks)))
    square = np.abs(turns @ (means - np.mean(means)) / blocks) ** 2
    return float(square @ of_noise) / _FINE
