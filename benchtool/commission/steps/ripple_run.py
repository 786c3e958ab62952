"""A run at a steady speed with the profile's law: whether its settings suit motor, link and sensors."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence

import numpy as np

from benchtool.analysis import Basis, Measurement, Window, torque_ripple
from benchtool.block import Block
from benchtool.commission.excitation import Excitation
from benchtool.commission.known import Known
from benchtool.commission.steps.offsets import CURRENTS
from benchtool.commission.steps.speed_control import gains
from benchtool.commission.steps.step import Finding
from benchtool.drive import CaptureRequest
from benchtool.protocol import Mode

_SPEED_SHARE = 0.25  # of the rated speed
_PERIODS, _LONGEST_S = 6.0, 2.0  # electrical
_SETTLE_S = 1.0
_RIPPLE = 0.5  # rms ripple of the current over what one vector changes
_VECTORS = 2.5  # of whose changes the torque may have ripple, peak to peak
_FLUX = 0.03
_OF_TRIP = 0.95
_OF_LINK = 2.0 / 3.0  # of u_dc: the length of a basic vector
_ROUNDING = 1.02
_FIXED = ("tpc", "tpc_stator")


class RippleRun:
    """Turn the shaft without load and look at torque, flux and currents at the control rate.

    Of the laws of a fixed voltage, u_s has to be within what the dc link has, and the ripple of the torque
    within what u_s T_k changes it by. The flux has to be at its reference, and no current near the trip level
    or the end of its sensor.
    """

    name = "ripple"
    needs: tuple[str, ...] = ("speed_loop",)
    sets: tuple[str, ...] = ()

    def plan(self, known: Known) -> tuple[Excitation, ...]:
        """Return a run at a quarter of the rated speed."""
        omega = _SPEED_SHARE * known.motor.omega_m_N_rad_s
        T_s = known.control_period_s
        duration_s = min(_LONGEST_S, _PERIODS * 2.0 * math.pi / (known.identified.pole_pairs * omega))
        rows = round(duration_s / T_s)
        friction = known.friction_Nm(omega)
        squares = (friction / known.torque_per_A) ** 2 + (_RIPPLE * known.vector_A) ** 2
        return (
            Excitation(
                f"run at {omega:.3g} rad/s",
                None,
                CaptureRequest(
                    (
                        *CURRENTS,
                        "torque",
                        "torque_reference",
                        "psi_s",
                        "psi_s_reference",
                        "theta_m",
                        "omega_m",
                        "law_clipped",
                        "adc_saturated",
                    ),
                    rows,
                ),
                squares * duration_s,
                {**known.in_force, **gains(known)},
                omega_m_rad_s=omega,
                settle_s=_SETTLE_S,
                work_J=friction * omega * duration_s,
                mode=Mode.VELOCITY,
            ),
        )

    def estimate(self, blocks: Sequence[Block], known: Known) -> Mapping[str, Measurement]:
        """Return torque ripple, error of the flux, greatest current, and what was clipped or saturated.

        Raises:
            AnalysisError: the speed is not steady, or a signal is dead.
        """
        (block,) = blocks
        window = Window.of(block, known.identified)
        basis = Basis(samples=len(block.data), sample_rate_Hz=block.sample_rate_Hz)
        found = list(torque_ripple(block, torque_rated_Nm=known.motor.T_N_Nm, track=window.track))
        flux = block.column("psi_s"), block.column("psi_s_reference")
        error = 100.0 * (float(np.mean(flux[0])) / float(np.mean(flux[1])) - 1.0)
        peak_A = max(float(np.max(np.abs(block.column(name)))) for name in CURRENTS)
        speed = float(np.mean(block.column("omega_m")))
        found += [
            Measurement("flux_error", error, "%", "mean of psi_s over that of its reference, less 1", basis),
            Measurement("current_peak", peak_A, "A", "greatest phase current", basis),
            Measurement("speed_mean", speed, "rad/s", "mean of omega_m", basis),
        ]
        for name in ("law_clipped", "adc_saturated"):
            column = block.column(name)
            found.append(Measurement(name, float(column[-1] - column[0]), "", f"increase of {name}", basis))
        return {each.name: each for each in found}

    def findings(self, found: Mapping[str, Measurement], known: Known) -> tuple[Finding, ...]:
        """Return which settings do not suit."""
        findings = []
        trip_A = float(known.held["i_trip"])
        if found["adc_saturated"].value > 0.0 or found["current_peak"].value > _OF_TRIP * trip_A:
            findings.append(
                Finding(
                    f"a phase current reaches {found['current_peak'].value:.4g} A without load, i_trip is "
                    f"{trip_A:.4g} A, {found['adc_saturated'].value:.0f} readings were at the sensor's end",
                    "the law's voltage is large for this inductance, or the sensors' range is small",
                    "lower u_s or T_k_ratio, choose another law, or raise i_trip within the sensors' range",
                )
            )
        if abs(found["flux_error"].value) > 100.0 * _FLUX:
            findings.append(
                Finding(
                    f"the stator flux is {found['flux_error'].value:+.3g} % off its reference, "
                    f"{100.0 * _FLUX:g} % is expected",
                    "the law cannot keep it: u_s is short, or its bands are wide",
                    "raise u_s within 2/3 of the dc link, or narrow flux_band",
                )
            )
        if known.law in _FIXED:
            findings += _of_fixed_voltage(found, known)
        return tuple(findings)


def _of_fixed_voltage(found: Mapping[str, Measurement], known: Known) -> list[Finding]:
    findings = []
    u_s, most = float(known.held["u_s"]), _OF_LINK * known.u_dc_V
    if u_s > _ROUNDING * most:
        findings.append(
            Finding(
                f"u_s is {u_s:.4g} V, the dc link of {known.u_dc_V:.4g} V has vectors of {most:.4g} V",
                "u_s is that of another dc link",
                f"set u_s to {most:.4g} V or less",
            )
        )
    most_Nm = _VECTORS * known.torque_per_A * known.vector_A
    ripple = found["torque_ripple_pp"].value
    if not ripple <= most_Nm:
        findings.append(
            Finding(
                f"the torque ripple is {ripple:.3g} Nm peak to peak, at most {most_Nm:.3g} Nm is expected of "
                f"u_s T_k",
                "the law's prediction does not fit the motor, or the encoder's angle is off",
                "identify the motor again, or lower T_k_ratio",
            )
        )
    return findings
