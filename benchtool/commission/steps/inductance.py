"""Inductances of both axes around zero current, with the rotor at rest near where it was aligned."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from benchtool.analysis import Basis, Measurement
from benchtool.block import Block
from benchtool.commission.budget import of_fit
from benchtool.commission.estimators.inductance import Turning, inductance
from benchtool.commission.excitation import Excitation
from benchtool.commission.known import Known
from benchtool.commission.steps.alignment import aligning
from benchtool.commission.steps.offsets import CURRENTS
from benchtool.commission.steps.step import Finding
from benchtool.drive import CaptureRequest, Stimulus

ALIGNED = "aligned_angle"
"""Name of the electrical angle at which an aligned rotor rests."""

_SHARE = 0.75  # of the rated current, peak, at the end of the ramp
_LEAST_SHARE = 0.3  # below which the converter's steps show, and the vector turns more slowly
_VOLTAGE_SHARE = 0.5  # of u_dc / sqrt(3)
_PERIODS = (14.38, 31.17)  # control periods in a turn of the vector: no two turns are sampled alike
_ROWS = 1200
_REPEATS = 3  # of each speed: of a motor of small inertia the noise of the currents decides
_LEFT_OUT_D, _LEFT_OUT_Q = 0.005, 0.006  # decision 0119
_OF_BENT = 0.75  # of what a current takes of an inductance: no more is known of its course, decision 0190
_LEFT_OUT_RAD = 0.03  # of the encoder's electrical angle, by its finer errors
_FACTOR = 2.5
_OF_LINE_TO_LINE, _NEAR = 0.5, 0.15


class TurningVoltage:
    """Align the rotor with phase a, then turn a growing voltage vector too fast for it to follow, at two
    speeds.

    Begun with nothing, the currents have no constant part that would kick the rotor, and on the average a
    turning vector makes no torque, in a salient machine neither. Two speeds tell the inductance from what the
    shaken rotor induces. The amplitude is that of a share of the rated current through the nameplate's
    impedance, or what the dc link allows; where that is too small a current to be read, the vector turns more
    slowly.
    """

    name = "inductance"
    needs: tuple[str, ...] = ("encoder",)
    sets: tuple[str, ...] = ("L_d", "L_q")

    def plan(self, known: Known) -> tuple[Excitation, ...]:
        """Return an alignment and a turning vector for each speed, repeated.

        Both are to find the rotor at one angle: harmonics make the EMF of a shaken rotor another elsewhere.
        """
        parameters = {"dead_time_compensation": 0.0, **known.offsets}
        return tuple(
            each
            for k, periods in enumerate(_REPEATS * _PERIODS)
            for each in (aligning(known, parameters, again=k > 0), _turning(known, periods))
        )

    def estimate(self, blocks: Sequence[Block], known: Known) -> Mapping[str, Measurement]:
        """Return `L_d` and `L_q`.

        Raises:
            AnalysisError: the captures do not define them.
        """
        turning = [block for block in blocks if "theta_m" in block.names]  # the others align
        found = inductance(
            [_directed(block, known) for block in turning],
            known.circuit,
            aligned_rad=0.0,
            aligned_standard_rad=_axis_standard_rad(known),
        )
        rows = sum(len(block.data) for block in turning)
        basis = Basis(samples=rows, sample_rate_Hz=1.0 / known.control_period_s)
        scatter = f"scatter of {rows} samples about the fit"
        both = (
            ("L_d", found.d, "along", _LEFT_OUT_D),
            ("L_q", found.q, "across", _LEFT_OUT_Q),
        )
        first = [
            known.pole_pairs * known.without_eccentricity(block.column("theta_m"))[0] for block in turning
        ]
        rests = Measurement(
            ALIGNED,
            float(np.angle(np.mean(np.exp(1j * np.array(first))))),
            "rad",
            "electrical angle at which the rotor rests after a current along phase a",
            basis,
        )
        return {ALIGNED: rests} | {
            name: Measurement(
                name,
                of.L_H,
                "H",
                f"flux linkage over current {side} the rotor flux, by a voltage vector that turns fast",
                basis,
                of_fit(of.L_H, of.standard_H, found.dof, scatter, known, left_out, _OF_BENT * abs(of.bent_H)),
            )
            for name, of, side, left_out in both
        }

    def findings(self, found: Mapping[str, Measurement], known: Known) -> tuple[Finding, ...]:
        """Return what the inductances say of the nameplate."""
        findings = []
        for name, stated in (("L_d", known.motor.L_d_H), ("L_q", known.motor.L_q_H)):
            ratio = found[name].value / stated
            if abs(ratio / _OF_LINE_TO_LINE - 1.0) < _NEAR:
                findings.append(
                    Finding(
                        f"{name} is {found[name].value:.4g} H, {ratio:.3g} times the nameplate's: L "
                        f"looks line to line",
                        f"motor.{name}_H is stated between two terminals",
                        "state the inductance of one phase, half of that between two terminals",
                        fails=False,
                    )
                )
            elif not 1.0 / _FACTOR < ratio < _FACTOR:
                findings.append(
                    Finding(
                        f"{name} is {found[name].value:.4g} H, {ratio:.3g} times the nameplate's",
                        "another motor, an inductance line to line, or a filter in the cable",
                        f"check motor.{name}_H of the profile",
                        fails=False,
                    )
                )
        return tuple(findings)


def _turning(known: Known, periods: float) -> Excitation:
    """Return the vector that turns once in so many control periods, or more slowly."""
    T_s, L = known.control_period_s, known.least_L_H
    most_V = _VOLTAGE_SHARE * known.u_dc_V / math.sqrt(3.0)
    a_turn_Vs = 2.0 * math.pi * L * known.I_N_A
    slower = max(1.0, _LEAST_SHARE * a_turn_Vs / (most_V * _PERIODS[0] * T_s))
    turn_s = slower * periods * T_s
    impedance_ohm = math.hypot(known.R_s_ohm, 2.0 * math.pi * L / turn_s)
    u_V = min(most_V, _SHARE * known.I_N_A * impedance_ohm + known.drop_fundamental_V)
    duration_s = (_ROWS + 2) * T_s
    return Excitation(
        f"{u_V:.3g} V at {1.0 / turn_s:.4g} Hz",
        Stimulus(
            quantity="voltage",
            shape="ramp",
            amplitude_V=u_V,
            duration_s=duration_s,
            omega_e_rad_s=2.0 * math.pi / turn_s,
        ),
        CaptureRequest((*CURRENTS, "u_alpha", "u_beta", "theta_m"), rows=_ROWS),
        (_SHARE * known.I_N_A) ** 2 * duration_s / 3.0,
        {"dead_time_compensation": 0.0, **known.offsets, **known.encoder},
    )


def _directed(block: Block, known: Known) -> Turning:
    """Return voltages and currents of a capture: what a row asks for acts from the next row on to the one
    after. The rotor is where the encoder says: friction may have kept it from where it was aligned."""
    u_V = block.column("u_alpha") + 1j * block.column("u_beta")
    turned = known.identified.pole_pairs * known.without_eccentricity(np.unwrap(block.column("theta_m")))
    return Turning(u_V[:-2], block.data[1:, :3], 0.5 * (turned[1:-1] + turned[2:]))


def _axis_standard_rad(known: Known) -> float:
    """Return the standard uncertainty of the electrical angle by the encoder."""
    offset = known.estimates.get("encoder_offset")
    standard = 0.0 if offset is None or offset.uncertainty is None else offset.uncertainty.standard
    return math.hypot(known.identified.pole_pairs * standard, _LEFT_OUT_RAD)
