"""Pure functions from samples to numbers that carry their definition.

Those that take a `Block` take one of plain arrays too: `benchtool.block.Block.from_arrays`.
"""

from benchtool.analysis.dynamics.bode import Bode, analyze_response
from benchtool.analysis.dynamics.frequency_response import FrequencyResponse, frequency_response
from benchtool.analysis.dynamics.step import StepResponse, analyze_step
from benchtool.analysis.flux_trajectory import flux_trajectory
from benchtool.analysis.measurement import (
    Basis,
    Measurement,
    Table,
    measurements_from_json,
    measurements_to_json,
    tables_from_json,
    tables_to_json,
)
from benchtool.analysis.orders.angle import AngleCoverage, angle_coverage
from benchtool.analysis.orders.order_spectrum import OrderSpectrum, fitted_orders, orders_at_speed
from benchtool.analysis.orders.orders import Orders, order_analysis
from benchtool.analysis.periods import PhaseTrack, track_angle, track_tone
from benchtool.analysis.quantisation import resolution
from benchtool.analysis.residual import torque_residual
from benchtool.analysis.ripple import (
    Ripple,
    peak_to_peak_number,
    percentile_range,
    ripple,
    ripple_numbers,
)
from benchtool.analysis.span import cut_to_span
from benchtool.analysis.spectra.current import CurrentSpectrum, current_spectrum
from benchtool.analysis.spectra.groups import (
    GroupDistortion,
    HarmonicGroups,
    group_distortion,
    group_table,
    harmonic_groups,
)
from benchtool.analysis.spectra.harmonics import (
    Distortion,
    Reference,
    distortion_and_noise,
    harmonic_table,
    harmonics,
    relative_phase_rad,
    total_harmonic_distortion,
)
from benchtool.analysis.spectra.lines import SpectralLines, spectral_lines
from benchtool.analysis.spectra.noise import NoiseFloor, harmonic_noise, noise_floor
from benchtool.analysis.spectra.spectrum import (
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
from benchtool.analysis.spectra.unbalance import current_unbalance
from benchtool.analysis.steady_state import SteadyState, analyze_steady_state
from benchtool.analysis.switching import (
    SwitchingStates,
    mean_switching_frequency_Hz,
    switching_frequency,
    switching_states,
)
from benchtool.analysis.torque import torque_ripple, true_torque
from benchtool.analysis.uncertainty import Contribution, Uncertainty

__all__ = [
    "AngleCoverage",
    "Basis",
    "Bode",
    "CoherentSamples",
    "CoherentSpectrum",
    "Component",
    "Contribution",
    "CurrentSpectrum",
    "Distortion",
    "FrequencyResponse",
    "GroupDistortion",
    "HarmonicGroups",
    "Measurement",
    "NoiseFloor",
    "OrderSpectrum",
    "Orders",
    "PhaseTrack",
    "Reference",
    "Ripple",
    "SpectralLines",
    "Spectrum",
    "SteadyState",
    "StepResponse",
    "SwitchingStates",
    "Table",
    "Uncertainty",
    "amplitude_spectrum",
    "analyze_response",
    "analyze_steady_state",
    "analyze_step",
    "angle_coverage",
    "coherent_samples",
    "coherent_spectrum",
    "current_spectrum",
    "current_unbalance",
    "cut_to_span",
    "distortion_and_noise",
    "fitted_orders",
    "flux_trajectory",
    "frequency_response",
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
    "order_analysis",
    "orders_at_speed",
    "peak_to_peak_number",
    "percentile_range",
    "relative_phase_rad",
    "resolution",
    "ripple",
    "ripple_numbers",
    "spectral_lines",
    "spectrum_of",
    "switching_frequency",
    "switching_states",
    "tables_from_json",
    "tables_to_json",
    "torque_residual",
    "torque_ripple",
    "total_harmonic_distortion",
    "track_angle",
    "track_tone",
    "true_torque",
]
