"""Pure functions from samples to numbers that carry their definition."""

from benchtool.analysis.current import CurrentSpectrum, current_spectrum
from benchtool.analysis.groups import (
    GroupDistortion,
    HarmonicGroups,
    group_distortion,
    group_table,
    harmonic_groups,
)
from benchtool.analysis.harmonics import (
    Distortion,
    Reference,
    distortion_and_noise,
    harmonic_table,
    harmonics,
    relative_phase_rad,
    total_harmonic_distortion,
)
from benchtool.analysis.measurement import (
    Basis,
    Measurement,
    Table,
    Uncertainty,
    measurements_from_json,
    measurements_to_json,
    tables_to_json,
)
from benchtool.analysis.noise import NoiseFloor, harmonic_noise, noise_floor
from benchtool.analysis.periods import PhaseTrack, track_angle, track_tone
from benchtool.analysis.ripple import (
    Ripple,
    peak_to_peak_number,
    percentile_range,
    resolution,
    ripple,
    ripple_numbers,
)
from benchtool.analysis.span import cut_to_span
from benchtool.analysis.spectrum import (
    CoherentSamples,
    CoherentSpectrum,
    Component,
    Spectrum,
    amplitude_spectrum,
    coherent_samples,
    coherent_spectrum,
    largest_low_component,
    spectrum_of,
)
from benchtool.analysis.steady_state import SteadyState, analyze_steady_state
from benchtool.analysis.switching import mean_switching_frequency_Hz
from benchtool.analysis.torque import torque_ripple, true_torque

__all__ = [
    "Basis",
    "CoherentSamples",
    "CoherentSpectrum",
    "Component",
    "CurrentSpectrum",
    "Distortion",
    "GroupDistortion",
    "HarmonicGroups",
    "Measurement",
    "NoiseFloor",
    "PhaseTrack",
    "Reference",
    "Ripple",
    "Spectrum",
    "SteadyState",
    "Table",
    "Uncertainty",
    "amplitude_spectrum",
    "analyze_steady_state",
    "coherent_samples",
    "coherent_spectrum",
    "current_spectrum",
    "cut_to_span",
    "distortion_and_noise",
    "group_distortion",
    "group_table",
    "harmonic_groups",
    "harmonic_noise",
    "harmonic_table",
    "harmonics",
    "largest_low_component",
    "mean_switching_frequency_Hz",
    "measurements_from_json",
    "measurements_to_json",
    "noise_floor",
    "peak_to_peak_number",
    "percentile_range",
    "relative_phase_rad",
    "resolution",
    "ripple",
    "ripple_numbers",
    "spectrum_of",
    "tables_to_json",
    "torque_ripple",
    "total_harmonic_distortion",
    "track_angle",
    "track_tone",
    "true_torque",
]
