"""Inductances of both axes around zero current, with the rotor at rest where it was aligned."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

from benchtool.analysis import Basis, Measurement
from benchtool.block import Block
from benchtool.commission.budget import of_fit
from benchtool.commission.estimators.inductance import Alternation, inductance
from benchtool.commission.excitation import Excitation
from benchtool.commission.known import Known
from benchtool.commission.steps.offsets import CURRENTS
from benchtool.commission.steps.step import Finding
from benchtool.drive import CaptureRequest, Stimulus

_ALIGN_S = 0.6
_ALIGN_SHARE = 0.7  # of the rated current
_SHARE = 0.4  # of the rated current, peak, that alternates
_VOLTAGE_SHARE = 0.5  # of u_dc / sqrt(3)
_LEAST_SHARE = 0.03  # below which the converter's steps show, and the frequency is lowered
_PERIODS = 6.3  # control periods in one of the alternation; no whole number, so that all phases are met
_SLOWER = 2.3
_ROWS = 800
_OF_A_STRETCH = 4  # periods of the alternation
_DIRECTIONS = 3
_FACTOR = 2.5


class Alternations:
    """Align the rotor with phase a, then have a voltage alternate along three directions, at two frequencies.

    The amplitude is that of a share of the rated current through the nameplate's inductance, or what the dc
    link allows; where that is too small a current to be read, both frequencies are lower.
    """

    name = "inductance"
    needs: tuple[str, ...] = ("resistance",)
    sets: tuple[str, ...] = ("L_d", "L_q")

    def plan(self, known: Known) -> tuple[Excitation, ...]:
        """Return the alignment, and an alternation along each direction."""
        align = Stimulus(
            quantity="current", shape="constant", amplitude_A=_ALIGN_SHARE * known.I_N_A, duration_s=_ALIGN_S
        )
        request = CaptureRequest((*CURRENTS, "u_alpha", "u_beta"), rows=_ROWS)
        duration_s = (_ROWS + 2) * known.control_period_s
        return (
            Excitation(
                "alignment",
                align,
                CaptureRequest(CURRENTS, rows=10),
                (_ALIGN_SHARE * known.I_N_A) ** 2 * _ALIGN_S,
                {"omega_current": known.damping_bandwidth_rad_s},
            ),
            *(
                Excitation(
                    f"{u_V:.3g} V, {1.0 / period_s:.4g} Hz at {math.degrees(angle_rad):.0f} deg",
                    Stimulus(
                        quantity="voltage",
                        shape="sine",
                        amplitude_V=u_V,
                        duration_s=duration_s,
                        frequency_Hz=1.0 / period_s,
                        angle_rad=angle_rad,
                    ),
                    request,
                    0.5 * (_SHARE * known.I_N_A) ** 2 * duration_s,
                    {"dead_time_compensation": 0.0},
                )
                for angle_rad in (k * math.pi / _DIRECTIONS for k in range(_DIRECTIONS))
                for u_V, period_s in _amplitudes(known)
            ),
        )

    def estimate(self, blocks: Sequence[Block], known: Known) -> Mapping[str, Measurement]:
        """Return `L_d` and `L_q`.

        Raises:
            AnalysisError: the captures do not define them.
        """
        periods_s = [period_s for _ in range(_DIRECTIONS) for _, period_s in _amplitudes(known)]
        found = inductance(
            [_directed(block, period_s) for block, period_s in zip(blocks[1:], periods_s, strict=True)],
            T_s=known.control_period_s,
            R_s_ohm=known.R_s_ohm,
            gains=known.gains,
            aligned_rad=0.0,
        )
        rows = sum(len(block.data) for block in blocks[1:])
        basis = Basis(samples=rows, sample_rate_Hz=1.0 / known.control_period_s)
        scatter = f"scatter of {rows} samples about the fit"
        both = (
            ("L_d", found.L_d_H, found.L_d_standard_H, "along"),
            ("L_q", found.L_q_H, found.L_q_standard_H, "across"),
        )
        return {
            name: Measurement(
                name,
                value,
                "H",
                f"flux linkage over current {side} the rotor flux, alternating around zero current",
                basis,
                of_fit(value, standard, found.dof, scatter, known),
            )
            for name, value, standard, side in both
        }

    def findings(self, found: Mapping[str, Measurement], known: Known) -> tuple[Finding, ...]:
        """Return what the inductances say of the nameplate."""
        findings = []
        for name, stated in (("L_d", known.motor.L_d_H), ("L_q", known.motor.L_q_H)):
            ratio = found[name].value / stated
            if not 1.0 / _FACTOR < ratio < _FACTOR:
                findings.append(
                    Finding(
                        f"{name} is {found[name].value:.4g} H, {ratio:.3g} times the nameplate's",
                        "another motor, an inductance line to line, or a filter in the cable",
                        f"check motor.{name}_H of the profile",
                        fails=False,
                    )
                )
        return tuple(findings)


def _amplitudes(known: Known) -> tuple[tuple[float, float], ...]:
    """Return voltage in V peak and period in s of the two alternations, the faster one first."""
    L = min(known.motor.L_d_H, known.motor.L_q_H)
    most_V = _VOLTAGE_SHARE * known.u_dc_V / math.sqrt(3.0)
    lowest = 2.0 * math.pi * L * _LEAST_SHARE * known.I_N_A / (most_V * known.control_period_s)
    faster_s = max(_PERIODS, lowest) * known.control_period_s
    wanted_Vs = 2.0 * math.pi * L * _SHARE * known.I_N_A
    return tuple(
        (min(most_V, wanted_Vs / period_s + known.drop_V), period_s)
        for period_s in (faster_s, _SLOWER * faster_s)
    )


def _directed(block: Block, period_s: float) -> Alternation:
    """Return voltages and currents of a capture: what a row asks for acts from the next row on to the one
    after."""
    u_V = block.column("u_alpha") + 1j * block.column("u_beta")
    stretch = math.ceil(_OF_A_STRETCH * period_s / block.tick_s)
    return Alternation(u_V[:-2], block.data[1:, :3], stretch)
