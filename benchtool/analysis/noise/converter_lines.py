"""Lines that the steps of a converter make in a spectrum, where they repeat with the signal."""

from __future__ import annotations

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSpectrum
from benchtool.analysis.quantisation.repeated_steps import RepeatedSteps, repeated_steps
from benchtool.analysis.quantisation.steps_along import are_alike, steps_of_lines

_MOSTLY = 0.95  # of the places of a converter's levels
_FOLDED = 4  # multiples of the rate
_MAIN_LOBE = 2.5  # bins beside a line under a squared Hann window


def converter_steps(
    spectrum: CoherentSpectrum,
    step: float,
    turns: NDArray[np.float64] | None = None,
    level: float | None = None,
) -> RepeatedSteps | None:
    """Return the errors that a converter's steps repeat with a signal, or make along one that lines between
    its harmonics take to other parts of the steps; None where there are none, or noise hides them.

    `turns`, shape (n,), are where the samples were taken, in periods from the first of the spectrum on, and
    `level` a value of the converter, where these are known.
    """
    periods, lines = spectrum.periods, spectrum.phasor[spectrum.periods :: spectrum.periods]
    if not step > 0.0:
        return None
    in_band = 2.0 * (len(spectrum.amplitude) / spectrum.samples)
    if not are_alike(spectrum.phasor, step, periods):
        return steps_of_lines(spectrum.phasor, step, periods, in_band)
    square = np.square(spectrum.amplitude)
    between = 0.5 * float(np.sum(square[1:]) - np.sum(square[periods::periods]))
    mean = float(spectrum.phasor[0].real)
    return repeated_steps(mean, lines, step, between / in_band, spectrum.samples, periods, turns, level)


def repeated_quantisation(
    spectrum: CoherentSpectrum, steps: RepeatedSteps | None
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return what a converter's steps, as far as they repeat with the signal, do to harmonics 1, 2 ...: the
    standard uncertainty of the amplitude of each, and the mean square of the amplitude that is added to each,
    both of shape (harmonics,)."""
    lines = spectrum.phasor[spectrum.periods :: spectrum.periods]
    none = np.zeros(len(lines))
    return (none, none) if steps is None else steps.of_lines(lines)


def aliased_quantisation(spectrum: CoherentSpectrum, step: float, harmonics: int = 1) -> NDArray[np.float64]:
    """Return the rms amplitude of errors of a converter's steps that fold to beside each of the first
    harmonics, shape (harmonics,), each as much as it moves a frequency by a fit under a Hann window, relative
    to a line a bin away.

    Where j periods hold nearly a whole number n of samples, orders n - h and n + h of the error fold to
    lines so few bins beside harmonic h that the window does not keep them off.
    """
    found = converter_steps(spectrum, step)
    if found is None:
        return np.zeros(harmonics)
    whole = np.arange(1, _FOLDED + 1) * (spectrum.samples / spectrum.periods)
    nearest = np.round(whole).astype(np.int64)
    apart = np.abs(nearest - whole) * spectrum.periods
    order = np.arange(1, harmonics + 1)[:, np.newaxis]
    below, above = ((nearest + by).ravel() for by in (-order, order))
    power = (found.power_at(below) + found.power_at(above)).reshape(harmonics, -1)
    # of int cos^4 t sin(2 pi d t) dt, which is near its greatest from half a bin to one and a half
    moved = np.minimum(1.0, 2.0 * apart) * (apart < _MAIN_LOBE)
    return np.asarray(np.sqrt(power @ moved**2))


def largest_of_steps(spectrum: CoherentSpectrum, steps: RepeatedSteps | None, below_order: float) -> float:
    """Return the amplitude that no line of a converter's errors below an order exceeds in 95 % of the cases.

    Orders above half of the rate fold down to between the harmonics: they are few lines, and no noise.
    """
    if steps is None:
        return 0.0
    per_period = spectrum.samples / spectrum.periods
    orders = np.arange(2, steps.highest_order + 1)
    folded = np.abs(orders - np.round(orders / per_period) * per_period)
    bin_order = 1.0 / spectrum.periods
    aside = (folded > bin_order) & (np.abs(folded - 1.0) > bin_order)
    return steps.largest_at(orders[aside & (folded < below_order)], _MOSTLY)
