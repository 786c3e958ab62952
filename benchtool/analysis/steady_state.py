"""Every number of a steady-state run, from one control-rate capture."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from benchtool.analysis.measurement import Measurement, MeasurementJson, Table, measurements_to_json
from benchtool.analysis.periods import PhaseTrack, track_angle, track_tone
from benchtool.analysis.ripple import ripple
from benchtool.analysis.span import cut_to_span
from benchtool.analysis.spectrum import (
    CoherentSpectrum,
    coherent_spectrum,
    largest_low_component,
    total_harmonic_distortion,
)
from benchtool.analysis.switching import mean_switching_frequency_Hz
from benchtool.analysis.validity import require_unbroken
from benchtool.block import Block
from benchtool.errors import AnalysisError

_LOW_ORDER = 10
_SMALLEST_MEAN = 1e-6  # share of the peak-to-peak ripple below which "percent of mean" says nothing


@dataclass(frozen=True)
class SteadyState:
    """Result of `analyze_steady_state`; `spectrum` is that of phase current a, in A peak."""

    measurements: tuple[Measurement, ...]
    spectrum: CoherentSpectrum
    tables: tuple[Table, ...] = ()

    @property
    def fundamental_Hz(self) -> float:
        return self.spectrum.fundamental_Hz

    @property
    def periods(self) -> int:
        """Whole electrical periods in the spectrum."""
        return self.spectrum.periods

    def __getitem__(self, name: str) -> Measurement:
        """The measurement of that name.

        Raises:
            AnalysisError: there is none.
        """
        for each in self.measurements:
            if each.name == name:
                return each
        names = ", ".join(each.name for each in self.measurements)
        raise AnalysisError(f"no measurement '{name}' in this analysis: it has {names}")

    def to_json(self) -> dict[str, MeasurementJson]:
        return measurements_to_json(self.measurements)


def analyze_steady_state(
    block: Block, *, pole_pairs: int, torque_rated_Nm: float, transducer: Block | None = None
) -> SteadyState:
    """Torque and flux ripple, current spectrum and switching frequency of a window in steady state.

    Args:
        block: a control-rate capture without gaps, with the drive's signals i_a, torque, psi_s and
            switching_count; with theta_m the electrical periods come from the rotor, without it from i_a.
        pole_pairs: pole pairs p of the machine.
        torque_rated_Nm: the base of `torque_ripple_percent_of_rated`.
        transducer: the true torque, channel torque_transducer, covering the capture's time.

    Raises:
        AnalysisError: a gap, a missing channel, a dead signal, fewer than two electrical periods, or a speed
            that is not steady.
    """
    require_unbroken(block)
    i_a = block.column("i_a")
    if "theta_m" in block.names:
        track = track_angle(block.column("theta_m"), pole_pairs)
    else:
        track = track_tone(i_a, "i_a")
    spectrum = coherent_spectrum(i_a, block.sample_rate_Hz, track, "i_a")
    measurements = (
        *_torque(block, torque_rated_Nm),
        *(_true_torque(cut_to_span(transducer, block), block) if transducer is not None else ()),
        *_flux(block),
        *_current(spectrum, track, block.sample_rate_Hz),
        *_switching(block),
    )
    return SteadyState(measurements, spectrum)


def _torque(block: Block, torque_rated_Nm: float) -> Iterator[Measurement]:
    torque = ripple(block.column("torque"), "Nm", "torque")
    window = _window(block)
    yield Measurement("torque_mean", torque.mean, "Nm", f"mean of the drive's estimate torque, {window}")
    peak_to_peak = f"maximum minus minimum of the drive's estimate torque, unfiltered, {window}"
    yield Measurement("torque_ripple_pp", torque.peak_to_peak, "Nm", peak_to_peak)
    deviation = f"rms of the drive's estimate torque about its mean, unfiltered, {window}"
    yield Measurement("torque_ripple_rms", torque.rms, "Nm", deviation)

    name, definition = "torque_ripple_percent_of_mean", "100 x torque_ripple_pp / |torque_mean|"
    if abs(torque.mean) > _SMALLEST_MEAN * torque.peak_to_peak:
        percent = 100.0 * torque.peak_to_peak / abs(torque.mean)
        yield Measurement(name, percent, "%", f"{definition}, {window}")
    else:
        yield Measurement.undefined(name, "%", f"{definition}, {window}", "the mean torque is zero")

    name, definition = "torque_ripple_percent_of_rated", "100 x torque_ripple_pp / rated torque"
    if torque_rated_Nm > 0.0:
        percent = 100.0 * torque.peak_to_peak / torque_rated_Nm
        yield Measurement(name, percent, "%", f"{definition} of {torque_rated_Nm:g} Nm, {window}")
    else:
        yield Measurement.undefined(name, "%", f"{definition}, {window}", f"it is {torque_rated_Nm:g} Nm")


def _true_torque(transducer: Block, block: Block) -> Iterator[Measurement]:
    torque = ripple(transducer.column("torque_transducer"), "Nm", "torque_transducer")
    definition = f"maximum minus minimum of torque_transducer, unfiltered, {_window(transducer)}"
    yield Measurement("true_torque_ripple_pp", torque.peak_to_peak, "Nm", definition)
    error_Nm = float(np.mean(block.column("torque"))) - torque.mean
    definition = f"mean of the drive's estimate torque minus mean of torque_transducer, {_window(block)}"
    yield Measurement("torque_error", error_Nm, "Nm", definition)


def _flux(block: Block) -> Iterator[Measurement]:
    psi_s = ripple(block.column("psi_s"), "Wb", "psi_s")
    definition = f"maximum minus minimum of the drive's estimate psi_s (peak), unfiltered, {_window(block)}"
    yield Measurement("flux_ripple_pp", psi_s.peak_to_peak, "Wb", definition)


def _current(spectrum: CoherentSpectrum, track: PhaseTrack, sample_rate_Hz: float) -> Iterator[Measurement]:
    f_1, periods = spectrum.fundamental_Hz, spectrum.periods
    window = (
        f"{periods} whole electrical periods ({spectrum.samples / sample_rate_Hz:.6g} s, "
        f"{spectrum.samples:.1f} samples at {sample_rate_Hz:g} Hz) by {track.source}"
    )
    definition = f"mean electrical frequency over {window}"
    yield Measurement("fundamental_frequency", f_1, "Hz", definition)

    dft = f"DFT of i_a over {window}, resampled to equal steps of that phase, rectangular window"
    definition = f"peak amplitude at {f_1:.6g} Hz, {dft}"
    yield Measurement("current_fundamental", float(spectrum.amplitude[periods]), "A", definition)

    distortion = total_harmonic_distortion(spectrum)
    last = distortion.highest_harmonic
    definition = f"100 x sqrt(sum of squared harmonics 2 to {last}) / fundamental, {dft}"
    if math.isnan(distortion.ratio) or last < 2:
        reason = "the fundamental is zero" if last >= 2 else "no harmonic is within the band"
        yield Measurement.undefined("current_thd", "%", definition, reason)
    else:
        yield Measurement("current_thd", 100.0 * distortion.ratio, "%", definition)

    largest = largest_low_component(spectrum, _LOW_ORDER)
    limit_Hz = min(_LOW_ORDER * f_1, float(spectrum.frequency_Hz[-1]))
    definition = (
        f"largest peak amplitude below {limit_Hz:.6g} Hz other than dc and the fundamental, here at "
        f"{largest.frequency_Hz:.6g} Hz; all bins, {f_1 / periods:.4g} Hz apart, {dft}"
    )
    yield Measurement("current_max_low_harmonic", largest.amplitude, "A", definition)


def _switching(block: Block) -> Iterator[Measurement]:
    frequency_Hz = mean_switching_frequency_Hz(block.column("switching_count"), 1.0 / block.sample_rate_Hz)
    definition = f"turn-ons of the three upper switches / (3 x duration), {_window(block)}"
    yield Measurement("switching_frequency_mean", frequency_Hz, "Hz", definition)


def _window(block: Block) -> str:
    rate_Hz = block.sample_rate_Hz
    return f"{len(block.data) / rate_Hz:.6g} s, {len(block.data)} samples at {rate_Hz:.6g} Hz"
