"""Pure functions from samples to numbers that carry their definition."""

from benchtool.analysis.measurement import (
    Basis,
    Measurement,
    Table,
    Uncertainty,
    measurements_from_json,
    measurements_to_json,
    tables_to_json,
)
from benchtool.analysis.periods import PhaseTrack, track_angle, track_tone
from benchtool.analysis.ripple import Ripple, ripple
from benchtool.analysis.span import cut_to_span
from benchtool.analysis.spectrum import (
    CoherentSpectrum,
    Component,
    Distortion,
    Spectrum,
    amplitude_spectrum,
    coherent_spectrum,
    harmonics,
    largest_low_component,
    total_harmonic_distortion,
)
from benchtool.analysis.steady_state import SteadyState, analyze_steady_state
from benchtool.analysis.switching import mean_switching_frequency_Hz

__all__ = [
    "Basis",
    "CoherentSpectrum",
    "Component",
    "Distortion",
    "Measurement",
    "PhaseTrack",
    "Ripple",
    "Spectrum",
    "SteadyState",
    "Table",
    "Uncertainty",
    "amplitude_spectrum",
    "analyze_steady_state",
    "coherent_spectrum",
    "cut_to_span",
    "harmonics",
    "largest_low_component",
    "mean_switching_frequency_Hz",
    "measurements_from_json",
    "measurements_to_json",
    "ripple",
    "tables_to_json",
    "total_harmonic_distortion",
    "track_angle",
    "track_tone",
]
