from .catalogue import (
    Catalogue as Catalogue,
    catalogue as catalogue,
    measure as measure,
)
from .coherent.spectrum import (
    CoherentSamples as CoherentSamples,
    CoherentSpectrum as CoherentSpectrum,
    Component as Component,
    Spectrum as Spectrum,
    amplitude_spectrum as amplitude_spectrum,
    coherent_samples as coherent_samples,
    coherent_spectrum as coherent_spectrum,
    harmonics as harmonics,
    largest_low_component as largest_low_component,
    spectrum_of as spectrum_of,
)
from .crop import crop_to as crop_to
from .declaration import (
    Analysis as Analysis,
    Drawing as Drawing,
    Findings as Findings,
    NoSettings as NoSettings,
    Panel as Panel,
    Quantity as Quantity,
)
from .distributions import (
    equally_likely as equally_likely,
    students_deviation as students_deviation,
)
from .flux.trajectory import flux_trajectory as flux_trajectory
from .lines.line_numbers import SpectralLines as SpectralLines
from .lines.lines import spectral_lines as spectral_lines
from .measurement import (
    Basis as Basis,
    Correction as Correction,
    Measurement as Measurement,
    Table as Table,
    measurements_from_json as measurements_from_json,
    measurements_to_json as measurements_to_json,
    tables_from_json as tables_from_json,
    tables_to_json as tables_to_json,
    undefined as undefined,
    without_uncertainty as without_uncertainty,
)
from .noise.noise import (
    NoiseFloor as NoiseFloor,
    harmonic_noise as harmonic_noise,
    noise_floor as noise_floor,
)
from .numbers import (
    NOTHING as NOTHING,
    as_written as as_written,
    count_of as count_of,
    degrees as degrees,
    number as number,
    placed as placed,
    probability as probability,
    raw as raw,
    signed as signed,
    stated as stated,
    with_expanded as with_expanded,
    with_unit as with_unit,
)
from .orders.angle import (
    AngleCoverage as AngleCoverage,
    angle_coverage as angle_coverage,
)
from .orders.order_spectrum import (
    OrderSpectrum as OrderSpectrum,
    fitted_orders as fitted_orders,
    orders_at_speed as orders_at_speed,
)
from .orders.orders import (
    Orders as Orders,
    order_analysis as order_analysis,
)
from .orders.speed_beside_angle import speed_beside_angle as speed_beside_angle
from .periods import (
    PhaseTrack as PhaseTrack,
    track_angle as track_angle,
    track_tone as track_tone,
)
from .phase.mean_frequency import angle_remarks as angle_remarks
from .plug_ins import guarded as guarded
from .quantisation.counted_line import (
    least_spread as least_spread,
    line_through_counts as line_through_counts,
)
from .quantisation.resolution import resolution as resolution
from .remarks import (
    correction_notes as correction_notes,
    pulse_note as pulse_note,
    repeatability_notes as repeatability_notes,
    signal_remarks as signal_remarks,
)
from .responses.bode import (
    Bode as Bode,
    analyze_response as analyze_response,
)
from .responses.estimated_response import FrequencyResponse as FrequencyResponse
from .responses.frequency_response import frequency_response as frequency_response
from .sensitivity import (
    OF_MEAN_STEP as OF_MEAN_STEP,
    Extremes as Extremes,
    Harmonics as Harmonics,
    Largest as Largest,
    Noise as Noise,
    Sensitivities as Sensitivities,
    Sensitivity as Sensitivity,
)
from .sensors.corrections import BANDWIDTH as BANDWIDTH
from .sensors.instruments import (
    Instruments as Instruments,
    Perturbed as Perturbed,
    sensor_remarks as sensor_remarks,
)
from .sensors.mean_reading import MeanReading as MeanReading
from .spectra.current import (
    CurrentSpectrum as CurrentSpectrum,
    current_spectrum as current_spectrum,
)
from .spectra.flat_crests import flat_crest_remark as flat_crest_remark
from .spectra.groups import (
    GroupDistortion as GroupDistortion,
    HarmonicGroups as HarmonicGroups,
    group_distortion as group_distortion,
    group_table as group_table,
    harmonic_groups as harmonic_groups,
)
from .spectra.harmonics import (
    Distortion as Distortion,
    Reference as Reference,
    distortion_and_noise as distortion_and_noise,
    harmonic_table as harmonic_table,
    relative_phase_rad as relative_phase_rad,
    total_harmonic_distortion as total_harmonic_distortion,
)
from .spectra.unbalance import current_unbalance as current_unbalance
from .statistics.lost_samples import continued as continued
from .statistics.mean_beside import MeanBeside as MeanBeside
from .statistics.regimes import change_of_regime as change_of_regime
from .statistics.scatter import error_of_record as error_of_record, error_of_series as error_of_series
from .statistics.straight_lines import (
    slope_of as slope_of,
    slope_weights as slope_weights,
    without_slope as without_slope,
)
from .steady_state import (
    SteadyState as SteadyState,
    analyze_steady_state as analyze_steady_state,
    steady_state_of as steady_state_of,
)
from .steps.step import (
    STEP as STEP,
    StepResponse as StepResponse,
    analyze_step as analyze_step,
)
from .switching import (
    SWITCHING_STATES as SWITCHING_STATES,
    SwitchingStates as SwitchingStates,
    mean_switching_frequency_Hz as mean_switching_frequency_Hz,
    switching_frequency as switching_frequency,
    switching_states as switching_states,
)
from .torque.residual import torque_residual as torque_residual
from .torque.ripple import (
    Ripple as Ripple,
    peak_to_peak_number as peak_to_peak_number,
    record_basis as record_basis,
    ripple as ripple,
    ripple_numbers as ripple_numbers,
    ripple_of_rows as ripple_of_rows,
)
from .torque.ripple_percentiles import percentile_range as percentile_range
from .torque.torque import (
    torque_ripple as torque_ripple,
    transducer_torque as transducer_torque,
)
from .uncertainty import (
    COVERAGE as COVERAGE,
    Contribution as Contribution,
    InstrumentError as InstrumentError,
    Uncertainty as Uncertainty,
    combined as combined,
    combined_by_names as combined_by_names,
    of_difference as of_difference,
    sure_of as sure_of,
)
from .validity import (
    clipping as clipping,
    held_rows as held_rows,
    require_signal as require_signal,
    require_unbroken as require_unbroken,
    standing as standing,
)
from .window import (
    PLAYED as PLAYED,
    Excitation as Excitation,
    Window as Window,
)
