"""Every number of a steady-state run, from one control-rate capture."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from benchtool.analysis.current import current_spectrum
from benchtool.analysis.measurement import Measurement, MeasurementJson, Table, measurements_to_json
from benchtool.analysis.periods import PhaseTrack, track_angle, track_tone
from benchtool.analysis.ripple import peak_to_peak_number
from benchtool.analysis.spectrum import CoherentSpectrum
from benchtool.analysis.switching import switching_frequency
from benchtool.analysis.torque import torque_ripple, true_torque
from benchtool.analysis.validity import require_unbroken
from benchtool.block import Block
from benchtool.errors import AnalysisError


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
    block: Block,
    *,
    pole_pairs: int,
    torque_rated_Nm: float,
    transducer: Block | None = None,
    current_rated_A_rms: float | None = None,
) -> SteadyState:
    """Torque and flux ripple, current spectrum and switching frequency of a window in steady state.

    Args:
        block: a control-rate capture without gaps that has i_a; torque, psi_s and switching_count are
            measured where they were recorded. With theta_m the electrical periods come from the rotor,
            without it from i_a.
        pole_pairs: pole pairs p of the machine.
        torque_rated_Nm: the base of the torque ripple of rated.
        transducer: the true torque, channel torque_transducer, covering the capture's time.
        current_rated_A_rms: the base of `current_tdd`, which is left out without it.

    Raises:
        AnalysisError: a gap, no i_a, a dead signal, fewer than two electrical periods, or a speed that is not
            steady.
    """
    require_unbroken(block)
    track = _track(block, pole_pairs)
    current = current_spectrum(block, "i_a", track, current_rated_A_rms=current_rated_A_rms)
    measurements: list[Measurement] = []
    estimate = None
    if "torque" in block.names:
        what = "the drive's estimate torque"
        measurements += torque_ripple(block, torque_rated_Nm=torque_rated_Nm, track=track, what=what)
        estimate = measurements[0]
    if transducer is not None:
        measurements += true_torque(transducer, block, estimate=estimate, track=track)
    if "psi_s" in block.names:
        what = "the drive's estimate psi_s (peak)"
        measurements.append(peak_to_peak_number(block, "psi_s", "flux_ripple_pp", track=track, what=what))
    measurements += current.measurements
    if "switching_count" in block.names:
        measurements.append(switching_frequency(block))
    return SteadyState(tuple(measurements), current.spectrum, current.tables)


def _track(block: Block, pole_pairs: int) -> PhaseTrack:
    if "theta_m" in block.names:
        return track_angle(np.ascontiguousarray(block.column("theta_m")), pole_pairs)
    return track_tone(np.ascontiguousarray(block.column("i_a")), "i_a")
