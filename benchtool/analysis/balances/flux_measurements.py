"""Measurements of a flux balance: the estimated parameters, their definitions and their correlations."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import Annotated, Final

import numpy as np
from pydantic import Field

from benchtool.analysis.balances.flux_balance import ESTIMATED, FluxBalance, flux_balance
from benchtool.analysis.balances.flux_model import NEEDED
from benchtool.analysis.balances.readings import of_readings
from benchtool.analysis.declaration import Analysis, Findings, Measured, Quantity
from benchtool.analysis.measurement import Basis, Measurement, Table
from benchtool.analysis.sensitivity import NO_SENSORS
from benchtool.analysis.statistics.scatter import TOO_SLOW, error_of_record, error_of_root
from benchtool.analysis.uncertainty import Uncertainty, combined
from benchtool.analysis.window import Window
from benchtool.block import Block
from benchtool.document import Section
from benchtool.errors import AnalysisError

UNITS: Final = {
    "R_s": "ohm",
    "L_d": "H",
    "L_q": "H",
    "psi_r": "Wb",
    "encoder_offset": "rad",
    "dead_time_voltage": "V",
    "current_gain_a": "",
    "current_gain_b": "",
    "current_gain_c": "",
}


class FluxBalanceSettings(Section):
    """When the voltage of a row acts."""

    delay_ticks: Annotated[int, Field(ge=0, le=3)] = 1
    """Ticks from a row to the period over which the voltage in it acts: 1 where a drive computes it in one
    period and applies it in the next."""


@dataclass(frozen=True)
class _Balanced:
    """Computes the flux balance of a window, for all analyses that rest on it."""

    delay_ticks: int

    def __call__(self, window: Window) -> FluxBalance:
        if window.motor is None:
            raise AnalysisError(
                "no motor is known, whose parameters are believed: give a profile with [motor]"
            )
        return flux_balance(window.block, window.motor, delay_ticks=self.delay_ticks)


def balance_of(window: Window, delay_ticks: int) -> FluxBalance:
    """Return the flux balance of a window, computed once.

    Raises:
        AnalysisError: no motor is known, or the data do not allow it.
    """
    return window.cached(_Balanced(delay_ticks))


def _measure(window: Window, settings: FluxBalanceSettings) -> Findings:
    found = balance_of(window, settings.delay_ticks)
    basis = _basis(found, window.block)
    return Findings(tuple(_measurements(found, basis)), (_correlations(found, basis),), found)


def _basis(found: FluxBalance, block: Block) -> Basis:
    used = len(found.left_out) - int(np.count_nonzero(found.left_out))
    p = found.belief
    return Basis(
        samples=used,
        sample_rate_Hz=block.sample_rate_Hz,
        duration_s=len(block.data) / block.sample_rate_Hz,
        bandwidth_Hz=0.5 * block.sample_rate_Hz,
        window=f"{used} of {len(found.left_out)} periods",
        reference=f"believed: R_s {p.R_s:g} ohm, L_d {p.L_d:g} H, L_q {p.L_q:g} H, psi_r {p.psi_r:g} Wb",
        gaps=0,
    )


def _measurements(found: FluxBalance, basis: Basis) -> Iterator[Measurement]:
    for name in ESTIMATED:
        definition, unit, full = _DEFINITIONS[name], UNITS[name], f"flux_balance_{name}"
        if reason := found.solution.why_not(name):
            yield Measurement.undefined(full, unit, definition, reason, basis)
            continue
        value = found.solution.value(name)
        link = found.link if name in _BY_LINK else None
        uncertain = found.solution.uncertainty(name, *(link.line(value / link.mean) if link else ()))
        sensed = of_readings(value, link, -1 if name in _PER_CURRENT else 0)
        each = Measurement(full, value, unit, definition, basis, uncertain, sensitivities=sensed)
        yield each.without_resolution_of(*(link.unresolved if link else ()))
    yield from _errors(found, basis)


def _errors(found: FluxBalance, basis: Basis) -> Iterator[Measurement]:
    """Yield the rms errors of predicted currents: those that are left scatter as noise does, and those of
    wrong parameters follow what this capture plays."""
    left, of_belief = found.error_A
    scatter = error_of_root(found.squares_A2, left, error_of_record(found.squares_A2))
    by_scatter = combined([scatter.line(_OF_SQUARES)], _OF_SQUARES)
    by_number = Uncertainty(of_belief / math.sqrt(2.0 * (basis.samples or 1.0)), "number of periods")
    rows = (
        ("flux_balance_error_rms", left, "estimated", by_scatter),
        ("flux_balance_belief_error_rms", of_belief, "believed", by_number),
    )
    for name, value, with_, uncertain in rows:
        text = f"rms error of the current predicted a tick ahead, with the {with_} parameters"
        why = TOO_SLOW if uncertain is None else ""
        yield Measurement(
            name, value, "A", text, basis, uncertain, uncertainty_reason=why, sensitivities=NO_SENSORS
        )


def _correlations(found: FluxBalance, basis: Basis) -> Table:
    places = [found.solution.names.index(name) for name in ESTIMATED]
    rows = found.solution.correlation[np.ix_(places, places)]
    return Table(
        "flux_balance_correlations",
        "correlation of the errors of the estimates, a row and a column for each in the same order",
        tuple((name, "") for name in ESTIMATED),
        tuple(tuple(float(cell) for cell in row) for row in rows),
        basis,
    )


_PER_CURRENT: Final = frozenset({"R_s", "L_d", "L_q"})
_BY_LINK: Final = _PER_CURRENT | {"psi_r", "dead_time_voltage"}  # voltages scale with that of the dc link
_GAIN = "gain of the current sensor of phase {}, over the mean of the three, minus 1"
_DEFINITIONS: Final = {
    "R_s": "resistance of a phase, with that of its devices, that balances the flux from tick to tick",
    "L_d": "inductance along the rotor flux that balances the flux from tick to tick",
    "L_q": "inductance across the rotor flux that balances the flux from tick to tick",
    "psi_r": "rotor flux linkage, peak, that balances the flux from tick to tick",
    "encoder_offset": "electrical angle by which the rotor flux is ahead of that of theta_m",
    "dead_time_voltage": "what dead time and devices take from the mean voltage of a phase against the sign "
    "of its current, beyond what the drive compensates",
    **{f"current_gain_{phase}": _GAIN.format(phase) for phase in "abc"},
}

_OF_SQUARES: Final = "scatter of the squared errors over parts of the capture, with their correlation"
_BY_SCATTER = "scatter of the errors of the balance over blocks, with their correlation"

FLUX_BALANCE: Final = Analysis(
    name="flux_balance",
    title="flux balance",
    measure=_measure,
    quantities=(
        *(
            Quantity(
                (f"flux_balance_{name}",),
                UNITS[name],
                _DEFINITIONS[name],
                _BY_SCATTER + ("; resolution of `u_dc`" if name in _BY_LINK else ""),
            )
            for name in ESTIMATED
        ),
        Quantity(
            ("flux_balance_error_rms",),
            "A",
            "rms error of the current predicted a tick ahead, with the estimated parameters",
            "scatter of its squares over 64 parts of the periods that are used, with their correlation",
        ),
        Quantity(
            ("flux_balance_belief_error_rms",),
            "A",
            "rms error of the current predicted a tick ahead, with the believed parameters",
            "`1 / sqrt(2 n)` of it",
        ),
    ),
    settings=FluxBalanceSettings,
    measured=Measured.ON_REQUEST,
    channels=NEEDED,
    every_tick=True,
)
