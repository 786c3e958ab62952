"""The fundamental of a current, and the largest line at low orders beside it, as numbers."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from benchtool.analysis.coherent.spectrum import CoherentSpectrum, Component, largest_low_component
from benchtool.analysis.measurement import Basis, Measurement
from benchtool.analysis.noise.converter_lines import largest_of_steps
from benchtool.analysis.noise.noise import noise_floor
from benchtool.analysis.noise.noise_of_lines import contribution_of_noise, line_noise
from benchtool.analysis.numbers import raw
from benchtool.analysis.sensitivity import Largest, Sensitivities, Sensitivity
from benchtool.analysis.spectra.line_errors import LineErrors
from benchtool.analysis.uncertainty import Contribution, Uncertainty, combined_by_names

_LOW_ORDER = 10


def fundamental_and_largest(
    spectrum: CoherentSpectrum,
    clean: CoherentSpectrum,
    errors: LineErrors,
    unit: str,
    channel: str,
    basis: Basis,
) -> Iterator[Measurement]:
    """Yield the fundamental, of a spectrum `clean` of all but the harmonics, and the largest low line."""
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
        f"{raw(largest.frequency_Hz, 6)} Hz; all bins, {raw(f_1 / periods, 4)} Hz apart, those of harmonics "
        f"without what tones between them leak there"
    )
    low = replace(basis, bandwidth_Hz=limit_Hz, frequency_Hz=largest.frequency_Hz)
    place = round(largest.frequency_Hz / spectrum.frequency_Hz[1])
    of_steps = largest_of_steps(clean, errors.steps, _LOW_ORDER)
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
