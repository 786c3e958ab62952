"""The noise between the harmonics of a current as numbers: of a bin, and per root of a frequency."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace

from benchtool.analysis.measurement import Basis, Measurement
from benchtool.analysis.noise.noise import NoiseFloor
from benchtool.analysis.noise.noise_of_periods import NoFloor
from benchtool.analysis.sensitivity import Noise, Sensitivities, Sensitivity
from benchtool.analysis.statistics.scatter import TOO_SLOW
from benchtool.analysis.uncertainty import Contribution, combined_by_names


def noise_numbers(
    floor: NoiseFloor | NoFloor, fundamental_Hz: float, unit: str, channel: str, basis: Basis
) -> Iterator[Measurement]:
    """Yield the noise floor of a current and its density; undefined without a floor."""
    which = (
        "bins between the harmonics, from the medians of bands of them / 0.8326 (Rayleigh), or where the "
        "density is steep the means of their squares"
    )
    names = (
        ("current_noise_floor", unit, f"rms over the peak amplitudes of the {which}"),
        ("current_noise_density", f"{unit}/sqrt(Hz)", f"rms per root of the width of a bin, of the {which}"),
    )
    for name, of, text in names:
        if isinstance(floor, NoFloor):
            yield Measurement.undefined(name, of, text, floor.value, basis)
            continue
        of_bins = name == "current_noise_floor"
        value = floor.amplitude if of_bins else floor.density
        of_bins_alone = Contribution(
            f"scatter of {floor.bins} bins in bands, and what the lines' motion may leave in them",
            "A",
            value * floor.relative_error,
            floor.dof,
        )
        changes = floor.by_time.line("change of its level with time", value)
        uncertain = combined_by_names((of_bins_alone, *([changes] if changes.standard != 0.0 else [])))
        yield Measurement(
            name,
            value,
            of,
            text,
            replace(basis, bin_Hz=floor.bin_Hz) if of_bins else basis,
            uncertain,
            uncertainty_reason="" if uncertain is not None else TOO_SLOW,
            sensitivities=Sensitivities((Sensitivity(channel, value),), Noise(fundamental_Hz)),
        )
