"""Standard uncertainties of harmonic amplitudes: noise, phase, resolution, and a wander of the amplitude."""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSpectrum, harmonics
from benchtool.analysis.noise.converter_lines import converter_steps, repeated_quantisation
from benchtool.analysis.noise.noise import harmonic_noise
from benchtool.analysis.noise.noise_of_lines import contribution_of_noise, line_noise
from benchtool.analysis.quantisation.repeated_steps import RepeatedSteps
from benchtool.analysis.spectra.modulation import is_modulated_alike, wander_of_mean
from benchtool.analysis.statistics.scatter import TOO_SLOW
from benchtool.analysis.uncertainty import Contribution

_SURE_OF_STEPS = 2.0
"""Standard deviations above the power that steps add on average, which it hardly exceeds."""


@dataclass(frozen=True)
class LineErrors:
    """Standard uncertainties of the amplitudes of harmonics 1, 2, 3 ..., all of shape (harmonics,).

    `noise`, of `dof` degrees of freedom, is by noise and leakage beside the line; `resampling` by that;
    `phase` what a phase that wanders by `wander_rad`, rms, takes off the line; `resolution` by the steps of a
    quantised signal, as far as they repeat with the period; `steps2` is the mean square of the amplitude that
    they add. `floor` is that of white noise around the line. `wander` is that of an amplitude that wanders
    too slowly for the bins beside the line, nan where the record is too short to tell it; lines that are
    modulated as the fundamental is have it in common, and so have all where the amplitude `had_trend`.
    `steps` are the errors of a converter as of samples at equal steps of phase. `beside` is what steady lines
    beside a harmonic, which are not in its amplitude, leave open of it.
    """

    noise: NDArray[np.float64]
    dof: NDArray[np.float64]
    floor: NDArray[np.float64]
    resampling: NDArray[np.float64]
    phase: NDArray[np.float64]
    resolution: NDArray[np.float64]
    steps2: NDArray[np.float64]
    wander: NDArray[np.float64]
    fit: NDArray[np.float64]
    beside: NDArray[np.float64]
    had_trend: bool = False
    steps: RepeatedSteps | None = None

    def first(self, orders: int) -> LineErrors:
        """Return those of so many harmonics."""
        arrays = {
            each.name: getattr(self, each.name)[:orders]
            for each in fields(self)
            if isinstance(getattr(self, each.name), np.ndarray)
        }
        return replace(self, **arrays)

    @property
    def standard(self) -> NDArray[np.float64]:
        """Combined standard uncertainty of each amplitude."""
        squares = self.noise**2 + self.resampling**2 + self.phase**2 + self.resolution**2 + self.wander**2
        squares += self.fit**2 + self.beside**2
        return np.asarray(np.sqrt(squares))

    @property
    def most_power_of_steps(self) -> float:
        """Sum of the squares that a converter adds to the amplitudes of harmonics 2 and above, at most."""
        power, apart = self.power_of_steps
        return power + _SURE_OF_STEPS * apart

    @property
    def power_of_steps(self) -> tuple[float, float]:
        """Sum of the squares that a converter adds to the amplitudes of harmonics 2 and above, and its
        standard deviation."""
        power = float(np.sum(self.steps2[1:]))
        if self.steps is None or not power > 0.0:
            return power, power
        return power, power * self.steps.scatter_of_power(np.arange(2, len(self.steps2) + 1))

    @property
    def unknown(self) -> str:
        """Why an amplitude has no uncertainty, where it has none."""
        return (
            TOO_SLOW
            if math.isnan(self.wander[0])
            else "the noise beside the lines is not known: record longer"
        )

    def budget(self, index: int, *, of_ratio: bool = False) -> tuple[Contribution, ...]:
        """Return the contributions to the amplitude of harmonic `index` + 1, without those that are zero; in
        a ratio of lines what they have in common cancels."""
        lines = (
            contribution_of_noise("noise and leakage beside the line", self.noise[index], self.dof[index]),
            Contribution("resampling", "B", self.resampling[index]),
            Contribution("wander of the phase", "B", self.phase[index]),
            Contribution("resolution", "B", self.resolution[index]),
            Contribution("wander of the amplitude", "A", 0.0 if of_ratio else self.wander[index]),
            Contribution("tones nearby, taken out", "B", self.fit[index]),
            Contribution("a line beside the harmonic", "B", self.beside[index]),
        )
        return tuple(each for each in lines if each.standard != 0.0)


def line_errors(
    spectrum: CoherentSpectrum,
    orders: int,
    wander_rad: float = 0.0,
    step: float = 0.0,
    amplitudes: NDArray[np.float64] | None = None,
    phases_rad: NDArray[np.float64] | None = None,
    turns: NDArray[np.float64] | None = None,
    level: float | None = None,
    of_angle: NDArray[np.float64] | None = None,
    of_fit: NDArray[np.float64] | None = None,
    with_trend: tuple[CoherentSpectrum, float] | None = None,
) -> LineErrors:
    """Of harmonics 1 to `orders`; the phase wanders by `wander_rad`, rms, the signal has steps of `step`, one
    of which is at `level`. `amplitudes` and `phases_rad`, shape (periods,), are those of the fundamental in
    each period; `turns` are where all rows of the record are, in periods from the first of the spectrum on;
    `of_angle` as in `Wander`; `of_fit`, shape (orders,), is what a fit of tones adds to the noise,
    relative to that; `with_trend` is the spectrum with what was a trend of the amplitude, and the relative
    standard uncertainty of the mean of that.
    """
    order = np.arange(1, orders + 1)
    amplitude = harmonics(spectrum)[:orders]
    noise = line_noise(spectrum, spectrum.periods * order)
    in_phase = noise.in_phase
    if with_trend is not None:  # harmonics that did not follow it have sidebands only without it
        in_phase = np.minimum(in_phase, line_noise(with_trend[0], spectrum.periods * order).in_phase)
    if turns is not None:
        turns = turns[(turns >= 0.0) & (turns < spectrum.periods)]
    steps = converter_steps(spectrum, step, level=level)
    resolution, steps2 = repeated_quantisation(spectrum, steps)
    if turns is not None and not (steps is not None and steps.are_few):  # of few steps places are no matter
        # what folds to places that hardly repeat is in the noise beside the lines already
        evenly = resolution
        resolution, steps2 = repeated_quantisation(spectrum, converter_steps(spectrum, step, turns, level))
        folded2 = np.maximum(0.0, resolution**2 - evenly**2)
        folded2[:orders] = np.maximum(0.0, folded2[:orders] - in_phase**2)
        resolution = np.sqrt(evenly**2 + folded2)
    phase = np.maximum(amplitude * np.minimum(1.0, 0.5 * (order * wander_rad) ** 2), noise.lost)
    if of_angle is not None:
        known = min(orders, len(of_angle))
        phase[:known] = np.hypot(phase[:known], of_angle[:known])
    return LineErrors(
        noise=in_phase,
        dof=noise.dof,
        floor=harmonic_noise(spectrum, orders),
        resampling=np.array(
            [spectrum.resampling_error(float(a), float(k)) for a, k in zip(amplitude, order, strict=True)]
        ),
        phase=phase,
        resolution=resolution[:orders],
        steps2=steps2[:orders],
        wander=_wander(spectrum, amplitude, in_phase, amplitudes, phases_rad, steps)
        if with_trend is None
        else with_trend[1] * amplitude,
        fit=np.zeros(orders) if of_fit is None else of_fit * in_phase,
        beside=np.zeros(orders),
        had_trend=with_trend is not None,
        steps=steps,
    )


def _wander(
    spectrum: CoherentSpectrum,
    amplitude: NDArray[np.float64],
    noise: NDArray[np.float64],
    amplitudes: NDArray[np.float64] | None,
    phases_rad: NDArray[np.float64] | None,
    steps: RepeatedSteps | None,
) -> NDArray[np.float64]:
    """Return what a slow wander of the fundamental's amplitude makes of each line that is modulated alike.

    Of the amplitudes' variance, what the errors of `steps` make is no wander: it is in the resolution.
    """
    none = np.zeros(len(amplitude))
    if amplitudes is None or not len(amplitude) or not amplitude[0] > 0.0:
        return none
    of_first = wander_of_mean(amplitudes, float(noise[0]), phases_rad)
    if of_first == 0.0 or math.isnan(of_first):
        return none + of_first
    if steps is not None:
        by_steps2 = _folded_into_periods(steps, spectrum.samples / spectrum.periods)
        of_first *= math.sqrt(max(0.0, 1.0 - by_steps2 / float(np.var(amplitudes, ddof=1))))
    alike = is_modulated_alike(spectrum, np.eye(len(amplitude)))
    alike[0] = True
    return np.where(alike, of_first / amplitude[0] * amplitude, 0.0)


def _folded_into_periods(steps: RepeatedSteps, per_period: float) -> float:
    """Return the variance of the amplitudes of periods of so many samples, by errors of orders above half of
    them: these fold to any phase of a period, and slowly to another one from period to period."""
    repeats = np.arange(1, int(0.5 * per_period) + 1)
    power = (
        float(np.mean(steps.errors**2)) - steps.of_mean() ** 2 - 0.5 * float(np.sum(steps.power_at(repeats)))
    )
    return 2.0 / per_period * max(0.0, power)
