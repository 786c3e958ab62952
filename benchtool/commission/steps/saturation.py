"""Saturation curve: the inductances over the current, by voltage pulses along both axes of the rotor."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

import numpy as np

from benchtool.analysis import Basis, Contribution, Measurement, combined
from benchtool.block import Block
from benchtool.commission.estimators.saturation import Curve, Pulse, saturation
from benchtool.commission.excitation import Excitation
from benchtool.commission.known import Known
from benchtool.commission.steps.alignment import aligning
from benchtool.commission.steps.inductance import ALIGNED
from benchtool.commission.steps.offsets import CURRENTS
from benchtool.commission.steps.step import Finding
from benchtool.drive import CaptureRequest, Stimulus

CURVE_PERCENT: Final = (-80, -40, 40, 80)
"""Of the rated current, at which the inductances are told."""

_AXES = (("d", 0.0), ("q", 0.5 * math.pi))
_REPEATS = 2
_TOP = 0.85  # of the rated current, at the end of a pulse
_FEWEST_PERIODS: Mapping[str, int] = {"d": 16, "q": 12}  # across, the rotor is moved meanwhile
_MOST_PERIODS = 400
_VOLTAGE_SHARE = 0.5  # of u_dc / sqrt(3)
_CREST = 4.0 / 3.0  # the longest vector of what dead time and devices take, over V_drop
_LEFT_OUT = 0.02
_FIRST = 0.15  # of what dead time takes in a period: in the first the current has no sign yet
_OF_ROTOR = 0.24  # of the EMF of a rotor that moves: its harmonics, not yet known, and its flux
_TOLD = 0.05  # largest relative expanded uncertainty of an inductance that is given


class Pulses:
    """Play pulses of voltage forth and back along the rotor flux and across it, each from no current on."""

    name = "saturation"
    needs: tuple[str, ...] = ("inductance",)
    sets: tuple[str, ...] = ()

    def plan(self, known: Known) -> tuple[Excitation, ...]:
        """Return pulses of both signs along both axes, twice each, each after the rotor is aligned.

        A pulse along the rotor flux leaves it about where it was: along the flux where friction and cogging
        let it rest, as the captures of the inductance have told.
        """
        parameters = {"dead_time_compensation": 0.0, **known.offsets}
        stands_rad = known.value(ALIGNED, 0.0)
        return tuple(
            each
            for axis, angle_rad in _AXES
            for k in range(2 * _REPEATS)
            for each in (
                aligning(known, parameters, again=axis == "d" and k > 0),
                _excitation(known, axis, stands_rad + angle_rad + math.pi * (k % 2)),
            )
        )

    def estimate(self, blocks: Sequence[Block], known: Known) -> Mapping[str, Measurement]:
        """Return `L_d_at_*` and `L_q_at_*`, by percent of the rated current.

        Raises:
            AnalysisError: the captures do not define them.
        """
        currents = np.array([share / 100.0 * known.I_N_A for share in CURVE_PERCENT])
        pulses = [_captured(block, known) for block in blocks[1::2]]
        curves = saturation(
            pulses[: 2 * _REPEATS],
            pulses[2 * _REPEATS :],
            currents,
            known.circuit,
            known.identified.psi_r_Wb,
        )
        found: dict[str, Measurement] = {}
        for axis, curve in (("d", curves.along), ("q", curves.across)):
            found |= {one.name: one for one in _measurements(axis, curve, known)}
        return found

    def findings(self, found: Mapping[str, Measurement], known: Known) -> tuple[Finding, ...]:
        """Return nothing: a motor may saturate."""
        return ()


def _periods(known: Known, axis: str) -> tuple[int, float]:
    """Return how many control periods a pulse lasts, and the voltage that the winding may have meanwhile.

    What dead time takes is known to a fraction of a percent, and of a small inductance the larger part of the
    voltage: the shorter the pulse, the less its error makes of the flux.
    """
    L = known.identified.L_d_H if axis == "d" else known.identified.L_q_H
    lost_V = _CREST * known.drop_V
    most_V = max(_VOLTAGE_SHARE * known.u_dc_V / math.sqrt(3.0) - lost_V, 0.1 * known.u_dc_V)
    needed = math.ceil(L * _TOP * known.I_N_A / (most_V * known.control_period_s))
    return min(max(_FEWEST_PERIODS[axis], needed), _MOST_PERIODS), most_V


def _excitation(known: Known, axis: str, angle_rad: float) -> Excitation:
    """Return a pulse of voltage, of a rotor that lies along phase a."""
    L = known.identified.L_d_H if axis == "d" else known.identified.L_q_H
    i_A, T_s, R_s = _TOP * known.I_N_A, known.control_period_s, known.R_s_ohm
    lost_V = _CREST * known.drop_V
    periods, most_V = _periods(known, axis)
    rises = -math.expm1(-R_s / L * periods * T_s) / R_s if R_s > 0.0 else periods * T_s / L
    u_V = min(i_A / rises, most_V) + lost_V
    duration_s = periods * T_s
    return Excitation(
        f"{u_V:.3g} V at {math.degrees(angle_rad):.0f} deg",
        Stimulus(
            quantity="voltage",
            shape="constant",
            amplitude_V=u_V,
            duration_s=duration_s,
            angle_rad=angle_rad,
        ),
        CaptureRequest((*CURRENTS, "u_alpha", "u_beta", "theta_m"), rows=periods),
        i_A**2 * duration_s / 3.0,
        {"dead_time_compensation": 0.0, **known.offsets, **known.encoder},
    )


def _captured(block: Block, known: Known) -> Pulse:
    """Return a capture: what a row asks for acts from the next row on to the one after."""
    u_V = (block.column("u_alpha") + 1j * block.column("u_beta"))[:-2]
    shaft = known.without_eccentricity(np.unwrap(block.column("theta_m")))
    readings = np.column_stack([block.column(name) for name in CURRENTS])
    return Pulse(u_V, readings[1:], known.identified.pole_pairs * shaft[1:])


def _measurements(axis: str, curve: Curve, known: Known) -> Iterator[Measurement]:
    basis = Basis(samples=2 * _REPEATS, sample_rate_Hz=1.0 / known.control_period_s)
    first_Wb = _FIRST * _CREST * abs(known.drop_V) * known.control_period_s
    lasts_s = _periods(known, axis)[0] * known.control_period_s
    rotor_Wb = known.identified.psi_r_Wb
    lost = known.estimates.get("dead_time_voltage")
    lost_Wb = (
        _CREST * lasts_s * (0.0 if lost is None or lost.uncertainty is None else lost.uncertainty.standard)
    )
    for percent, i_A, L_H, standard, moved_rad in zip(
        CURVE_PERCENT, curve.currents_A, curve.L_H, curve.standard_H, curve.moved_rad, strict=True
    ):
        if axis == "q" and percent < 0:
            continue  # as with the other sign
        name = f"L_{axis}_at_{'minus_' if percent < 0 else ''}{abs(percent)}"
        definition = f"flux linkage over current at i_{axis} = {i_A:.4g} A, less that of the rotor"
        lines = [
            Contribution("scatter of the pulses about the curve", "A", float(standard), curve.dof),
            Contribution("dead time in the first period", "B", first_Wb / abs(float(i_A)) / math.sqrt(3.0)),
            Contribution("dead time of the others", "B", lost_Wb / abs(float(i_A))),
            Contribution(
                "rotor flux that moves", "B", _OF_ROTOR * rotor_Wb * moved_rad / abs(i_A) / math.sqrt(3.0)
            ),
            Contribution("what the equation leaves out", "B", abs(float(L_H)) * _LEFT_OUT / math.sqrt(3.0)),
        ]
        u = combined(lines, "scatter of the pulses about the curve")
        if u is None or not u.expanded < _TOLD * float(L_H):
            large = "" if u is None else f" with an expanded uncertainty of {u.expanded:.2g}"
            moved = f"the rotor moved by {math.degrees(moved_rad):.2g} degrees"
            reason = f"{L_H:.3g} H{large}, {moved}: not determined"
            yield Measurement.undefined(name, "H", definition, reason, basis)
        else:
            yield Measurement(name, float(L_H), "H", definition, basis, u)
