"""Every number of a steady-state run, from one control-rate capture."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

from benchtool.analysis.catalogue import CORE
from benchtool.analysis.coherent.spectrum import CoherentSpectrum
from benchtool.analysis.declaration import Findings
from benchtool.analysis.measurement import Measurement, MeasurementJson, Table, measurements_to_json
from benchtool.analysis.spectra.current import CURRENT_SPECTRUM
from benchtool.analysis.validity import require_unbroken
from benchtool.analysis.window import Window
from benchtool.block import Block
from benchtool.errors import AnalysisError


@dataclass(frozen=True)
class SteadyState:
    """Result of `analyze_steady_state`; `spectrum` is that of i_a, in A peak; None without that channel."""

    measurements: tuple[Measurement, ...]
    spectrum: CoherentSpectrum | None
    tables: tuple[Table, ...] = ()

    @property
    def names(self) -> frozenset[str]:
        """Names of the measurements."""
        return frozenset(each.name for each in self.measurements)

    @property
    def current_spectrum(self) -> CoherentSpectrum:
        """The spectrum of i_a.

        Raises:
            AnalysisError: i_a was not recorded.
        """
        if self.spectrum is None:
            raise AnalysisError("without channel 'i_a' there is no current spectrum: record it too")
        return self.spectrum

    @property
    def fundamental_Hz(self) -> float:
        """Of the current; raises AnalysisError as `current_spectrum`."""
        return self.current_spectrum.fundamental_Hz

    @property
    def periods(self) -> int:
        """Whole electrical periods in the spectrum; raises AnalysisError as `current_spectrum`."""
        return self.current_spectrum.periods

    def __getitem__(self, name: str) -> Measurement:
        """Return the measurement of that name.

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
    """Return torque and flux ripple, current spectrum and switching frequency of a window in steady state.

    All analyses of `catalogue.CORE` are made whose channels are there.

    Args:
        block: a control-rate capture without gaps. With theta_m the electrical periods come from the rotor,
            without it from i_a; without both, numbers have no uncertainty from the scatter over periods.
        pole_pairs: pole pairs p of the machine.
        torque_rated_Nm: the base of the torque ripple of rated.
        transducer: channel torque_transducer, covering the capture's time.
        current_rated_A_rms: the base of `current_tdd`, which is left out without it.

    Raises:
        AnalysisError: a gap, a dead signal, fewer than two electrical periods, or a speed that is not steady.
    """
    require_unbroken(block)
    window = Window(block, pole_pairs, torque_rated_Nm, current_rated_A_rms, transducer)
    channels, shaft = frozenset(block.names), transducer is not None
    found = {}
    for analysis in CORE:
        settings = analysis.settings()
        if analysis.possible(channels, settings, transducer=shaft):
            found[analysis.name] = analysis.measure(window, settings)
    return steady_state_of(found)


def steady_state_of(findings: Mapping[str, Findings]) -> SteadyState:
    """Return the findings of analyses of one window, by name, combined; those of `catalogue.CORE` count."""
    core = [findings[each.name] for each in CORE if each.name in findings]
    current = findings.get(CURRENT_SPECTRUM.name)
    return SteadyState(
        tuple(each for part in core for each in part.measurements),
        None if current is None else current.result,
        tuple(each for part in core for each in part.tables),
    )
