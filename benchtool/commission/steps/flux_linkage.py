"""The rotor's flux linkage, from the voltage of the motor at several speeds in both directions."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis import Basis, Contribution, Measurement, combined, sure_of
from benchtool.block import Block
from benchtool.commission.budget import of_two
from benchtool.commission.estimators.dead_share import DeadShare, Spun, dead_share
from benchtool.commission.estimators.flux_linkage import (
    TurningFlux,
    turning_flux,
)
from benchtool.commission.estimators.regression import least_squares
from benchtool.commission.estimators.vectors import drop_vector, vector_of
from benchtool.commission.excitation import Excitation
from benchtool.commission.known import Known
from benchtool.commission.nameplate import probable_cause
from benchtool.commission.second_opinion import balanced, contradictions
from benchtool.commission.steps.flux_harmonics import angle_of, flux_harmonics, scatter_of
from benchtool.commission.steps.offsets import CURRENTS
from benchtool.commission.steps.saturation import CURVE_PERCENT
from benchtool.commission.steps.speed_loop import FASTEST, at_speed, settling_s
from benchtool.commission.steps.step import Finding
from benchtool.drive import CaptureRequest, Stimulus

_SPEEDS = (0.28, 0.32, 0.36)  # of the rated speed: a trip is at half, and steps of i_d move it by 15 %
_SHARES = (0.35, 0.75)  # of the rated current, along the rotor flux: least and most
_OF_FLUX = 0.25  # of the rotor flux, by that current at most: what saturation bends is not the magnet's
_CALM, _ANGLE_LEFT_RAD = 0.1, 0.03  # of the rated speed; electrical, beside what is known of the encoder
_HARMONICS = 0.24  # of the EMF, the fifth and the seventh together: as torque of a current along the flux
_OVERSHOOT = 1.65  # of the current when it is reversed, with what harmonics drive and friction takes
_ACROSS = 0.06  # of what dead time takes across the flux, left after its correction
_LEVELS = 3  # of it, a binary sequence: forth, back and forth
_SETTLED = 6.0  # time constants of the current loop, after which it stands
_TURNS = 12.0  # electrical
_FEWEST_ROWS, _MOST_ROWS = 1500, 8000
_LEFT_OUT = 0.0015  # decision 0119
_ROUNDED = 0.008  # of the voltage of dead time and devices: what its course near zero current is off by
_OF_CURVE = 3.0  # degrees of freedom of its curve
_BENT = 0.2  # of L_d: what it differs by between both signs of the current at most, where no curve tells
_FACTOR = 1.35  # of the nameplate's flux, that no magnet is off by
_AS_STATED, _NEAR = 1.21, 0.04  # a deviation that tells nothing; of a factor between two conventions
_ANGLE_RAD = math.radians(8.0)


class BackEmf:
    """Hold three speeds in both directions, with a current along the rotor flux, forth, back and forth."""

    name = "flux_linkage"
    needs: tuple[str, ...] = ("inductance", "encoder")
    sets: tuple[str, ...] = ("psi_r",)

    def plan(self, known: Known) -> tuple[Excitation, ...]:
        """Return a capture at each speed; none where the shaft may not turn round."""
        if math.isfinite(known.travel_rad):
            return ()
        motor, T_s = known.motor, known.control_period_s
        found = []
        for share in _SPEEDS:
            omega = share * motor.omega_m_N_rad_s
            rows = _TURNS * 2.0 * math.pi / (motor.pole_pairs * omega * T_s)
            rows = round(min(max(rows, _FEWEST_ROWS), _MOST_ROWS))
            duration_s = (rows + 3) * T_s
            amplitude = _amplitude_A(known)
            for sense in (1.0, -1.0):
                settle_s = settling_s(known, omega)
                found.append(
                    Excitation(
                        f"{sense * omega:.3g} rad/s",
                        Stimulus(
                            quantity="d_current",
                            shape="prbs",
                            amplitude_A=amplitude,
                            prbs_clock_s=duration_s / _LEVELS,
                            prbs_length=2,
                            seed=1,
                        ),
                        CaptureRequest((*CURRENTS, "u_alpha", "u_beta", "theta_m", "u_dc"), rows=rows),
                        amplitude**2 * duration_s,
                        at_speed(known),
                        sense * omega,
                        settle_s,
                    )
                )
        return tuple(found)

    def estimate(self, blocks: Sequence[Block], known: Known) -> Mapping[str, Measurement]:
        """Return `psi_r`.

        Raises:
            AnalysisError: the captures do not define it.
        """
        definition = (
            "slope of the EMF over the electrical speed, both ways, by the flux that turns with the rotor"
        )
        if not blocks:
            reason = f"the shaft may turn {known.travel_rad:.3g} rad only: no EMF worth measuring"
            return {"psi_r": Measurement.undefined("psi_r", "Wb", definition, reason)}
        captures = [_Capture.of(block, known) for block in blocks]
        (lopsided_Wb, saturation), share = _lopsided(known), _dead_share(captures, known)
        turning = _turning(captures, known, share.taken_V)
        omega = np.array([each.omega_e_rad_s for each in turning])
        found = _regression(np.array([each.psi_r_Wb for each in turning]) - lopsided_Wb, omega)
        moved = _turning(captures, known, share.taken_at(share.value + share.standard))
        other = _regression(np.array([each.psi_r_Wb for each in moved]) - lopsided_Wb, omega)
        rows = sum(len(block.data) for block in blocks)
        own = math.sqrt(sum(each.psi_r_standard_Wb**2 for each in turning)) / len(turning)
        lines = [
            Contribution("scatter over speeds and directions", "A", found.standard_Wb, found.dof),
            Contribution("deviations from a circle", "A", own, sum(each.dof for each in turning)),
            Contribution(
                "step of the converter of the dc link",
                "B",
                found.psi_Wb * known.link_step_V / known.u_dc_V / math.sqrt(12.0),
            ),
            Contribution("voltage that slow speeds show more of", "B", found.curved_Wb),
            Contribution("dead time across the flux", "B", _across_Wb(blocks[-1], turning[-1], known)),
            Contribution("dead time near zero current", "B", _rounded_Wb(turning[-1], known)),
            Contribution("dead time and devices, their shares", "A", abs(other.psi_Wb - found.psi_Wb)),
            saturation,
            Contribution("what the equation leaves out", "B", found.psi_Wb * _LEFT_OUT / math.sqrt(3.0)),
        ]
        measured = [
            Measurement(
                "psi_r",
                found.psi_Wb,
                "Wb",
                definition,
                Basis(samples=rows, sample_rate_Hz=1.0 / known.control_period_s),
                combined(lines, "scatter of the EMF about the line"),
            )
        ]
        of_orders = tuple(
            flux_harmonics(
                blocks,
                turning,
                moved,
                known,
                _mean_rounded_Wb(turning, known),
                _ACROSS / _ROUNDED * _mean_rounded_Wb(turning, known),
            )
        )
        told = known.with_estimates({each.name: each for each in of_orders})
        measured += [*balanced(blocks, told), _angle(blocks, turning, known), *of_orders]
        return {each.name: each for each in measured}

    def findings(self, found: Mapping[str, Measurement], known: Known) -> tuple[Finding, ...]:
        """Return where the flux contradicts the nameplate, the encoder's offset, or the flux balance."""
        findings = list(contradictions(found, known))
        findings += _of_nameplate(found["psi_r"].value, known)
        angle = found.get("angle_difference")
        if angle is not None and abs(angle.value) > _ANGLE_RAD:
            findings.append(
                Finding(
                    f"the voltage of the turning motor puts the encoder "
                    f"{math.degrees(angle.value):.2g} degrees "
                    f"electrical from where the current had put it",
                    "a load that pulls one way while the rotor was dragged, or an encoder that slips "
                    "or loses "
                    "counts",
                    "uncouple the load, tighten the encoder, and commission the encoder again",
                )
            )
        return tuple(findings)


def _lopsided(known: Known) -> tuple[float, Contribution]:
    """Return by how much a current along the rotor flux raises that in Wb, mean of forth and back, as the
    curve of saturation has it, with its uncertainty; 0 where that tells no difference between both signs."""
    percent = CURVE_PERCENT[-1]
    forth, back = (known.estimates.get(f"L_d_at_{sign}{percent}") for sign in ("", "minus_"))
    per_H = 0.5 * _amplitude_A(known) ** 2 / (percent / 100.0 * known.I_N_A)
    if forth is None or back is None:
        half_width_Wb = per_H * _BENT * known.identified.L_d_H
        return 0.0, Contribution(
            "saturation, of which no curve is known", "B", half_width_Wb / math.sqrt(3.0)
        )
    of_both, difference_H = of_two(forth, back), forth.value - back.value
    told = abs(difference_H) >= sure_of(of_both)
    standard_H = 0.0 if of_both is None else of_both.standard
    return per_H * difference_H * told, Contribution("saturation", "A", per_H * standard_H, _OF_CURVE)


def _amplitude_A(known: Known) -> float:
    """Return the current along the rotor flux: the larger, the less dead time takes across the flux.

    An eccentric encoder has a part of it make torque. When the current is reversed, that moves a speed which
    a critically damped controller of the gain K_p holds, by 2/e of the change over K_p at most. The harmonics
    of the EMF have it hold the rotor six times in a revolution of the flux, a work of psi_r i times their
    share: half of the kinetic energy at the slowest speed is left, or the rotor would rest there.
    """
    motor = known.identified
    bends_A = _OF_FLUX * motor.psi_r_Wb / motor.L_d_H
    aside_rad = _ANGLE_LEFT_RAD + motor.pole_pairs * math.hypot(*map(abs, known.eccentricity_rad))
    K_p = at_speed(known)["K_p_speed"]
    assert isinstance(K_p, float)
    moves_rad_s = 2.0 * known.torque_per_A * aside_rad * 2.0 / math.e / K_p  # per ampere
    calm_A = _CALM * known.motor.omega_m_N_rad_s / moves_rad_s
    slowest = _SPEEDS[0] * known.motor.omega_m_N_rad_s
    passes_A = 0.5 * motor.J_kgm2 * slowest**2 / (motor.psi_r_Wb * _HARMONICS)
    E = motor.pole_pairs * motor.psi_r_Wb * FASTEST * known.motor.omega_m_N_rad_s
    ripple = E * (known.pwm_period_s or known.control_period_s) / (4.0 * motor.L_q_H)
    trip_A = float(known.held.get("i_trip", known.I_N_A))
    safe_A = (trip_A - 2.0 * ripple) / _OVERSHOOT
    least, most = (share * known.I_N_A for share in _SHARES)
    return min(max(least, min(bends_A, calm_A, safe_A, passes_A)), most)


def _of_nameplate(psi_r_Wb: float, known: Known) -> Iterator[Finding]:
    """Yield that the nameplate's flux is another one, with what it probably is."""
    ratio = psi_r_Wb / known.motor.psi_r_Wb
    if not math.isfinite(ratio) or 1.0 / _AS_STATED < ratio < _AS_STATED:
        return
    seen = f"psi_r is {psi_r_Wb:.4g} Wb, {ratio:.3g} times the nameplate's"
    if cause := probable_cause("psi_r", psi_r_Wb, known.motor, _NEAR):
        yield Finding(
            f"{seen}: {cause}",
            "Kv, Ke or Kt in another convention (peak or rms, phase or line to line, mechanical or "
            "electrical)",
            "state the convention of the nameplate's constant, or correct motor.psi_r_Wb of the profile",
            fails=False,
        )
    elif not 1.0 / _FACTOR < ratio < _FACTOR:
        yield Finding(
            seen,
            "Kv or Ke in another convention (peak or rms, phase or line to line), or another motor",
            "check motor.psi_r_Wb of the profile",
            fails=False,
        )


@dataclass(frozen=True)
class _Line:
    psi_Wb: float
    standard_Wb: float
    dof: float
    curved_Wb: float


def _regression(psi: NDArray[np.float64], omega: NDArray[np.float64]) -> _Line:
    """Return the slope of E = psi omega over the speeds, and how far that differs if all count alike.

    What is left of the voltage of dead time and devices is the smaller, the faster the EMF takes a phase
    current through zero: a speed counts by its square.
    """
    E = psi * omega
    fit = least_squares(omega[:, None] * np.abs(omega)[:, None], E * np.abs(omega))
    alike = least_squares(omega[:, None], E)
    slope = float(fit.x[0])
    return _Line(slope, fit.standard(0), fit.dof, abs(float(alike.x[0]) - slope))


def _angle(blocks: Sequence[Block], turning: Sequence[TurningFlux], known: Known) -> Measurement:
    """Return by how much the encoder's electrical angle is ahead of that of the flux, mean over the
    captures."""
    ahead = []
    for block, each in zip(blocks, turning, strict=True):
        shaft = known.without_eccentricity(angle_of(block))[each.rows]
        ahead.append(np.mean(np.exp(1j * (known.identified.pole_pairs * shaft - each.angle_rad))))
    angles = np.angle(np.array(ahead) * np.conj(np.mean(ahead))) + np.angle(np.mean(ahead))
    p, counts = known.identified.pole_pairs, 4.0 * known.encoder_lines
    flux_Wb = float(np.mean([each.psi_r_Wb for each in turning]))
    lines = [
        scatter_of(angles),
        Contribution("count of the encoder", "B", 2.0 * math.pi * p / counts / math.sqrt(12.0)),
        Contribution("dead time along the current", "B", _mean_rounded_Wb(turning, known) / flux_Wb),
    ]
    definition = "electrical angle by which the encoder is ahead of the flux that the voltage makes"
    u = combined(lines, "scatter over speeds and directions")
    return Measurement("angle_difference", float(np.mean(angles)), "rad", definition, uncertainty=u)


@dataclass(frozen=True)
class _Capture:
    """Voltages over each period, currents at their ends, as readings and as vectors, and the electrical angle
    of the rotor in each."""

    u_V: NDArray[np.complex128]
    readings_A: NDArray[np.float64]
    i_A: NDArray[np.complex128]
    rotor_rad: NDArray[np.float64]

    @classmethod
    def of(cls, block: Block, known: Known) -> _Capture:
        u_V = (block.column("u_alpha") + 1j * block.column("u_beta"))[:-2]
        readings_A = np.column_stack([block.column(name) for name in CURRENTS])[1:]  # the drive has the gains
        theta_m = known.without_eccentricity(np.unwrap(block.column("theta_m")))[1:]
        rotor_rad = known.identified.pole_pairs * 0.5 * (theta_m[1:] + theta_m[:-1])
        return cls(u_V, readings_A, vector_of(readings_A), rotor_rad)


def _dead_share(captures: Sequence[_Capture], known: Known) -> DeadShare:
    """Return which part of what dead time and devices take is the dead time's."""
    motor, spun = known.identified, []
    rough = _turning(captures, known, [_nothing_known(each, known) for each in captures])
    for of, each in zip(captures, rough, strict=True):
        emf_V = 1j * each.omega_e_rad_s * each.psi_r_Wb * np.exp(1j * of.rotor_rad)
        spun.append(Spun(of.u_V, of.i_A, of.rotor_rad, emf_V, each.rows[each.rows < len(of.u_V)]))
    return dead_share(spun, known.circuit, motor.L_d_H, motor.L_q_H)


def _nothing_known(of: _Capture, known: Known) -> NDArray[np.complex128]:
    """Return what dead time and devices take of currents that keep their sign."""
    return known.drop_V * drop_vector(of.readings_A[1:])


def _turning(
    captures: Sequence[_Capture], known: Known, taken_V: Sequence[NDArray[np.complex128]]
) -> list[TurningFlux]:
    """Return what captures tell, less what dead time and devices take of each."""
    motor = known.identified
    return [
        turning_flux(
            of.u_V - taken,
            of.i_A,
            T_s=known.control_period_s,
            R_s_ohm=known.R_s_ohm,
            L_d_H=motor.L_d_H,
            L_q_H=motor.L_q_H,
            stretches=_stretches(len(of.i_A), known),
        )
        for of, taken in zip(captures, taken_V, strict=True)
    ]


def _across_Wb(block: Block, of: TurningFlux, known: Known) -> float:
    """Return what the voltage of dead time and devices across the flux may be off by, as a flux: a share of
    what goes with the current that overcomes friction."""
    i = vector_of(np.column_stack([block.column(name) for name in CURRENTS])[1:])[of.rows]
    i_q = float(np.mean((i * np.exp(-1j * of.angle_rad)).imag))
    across_V = known.drop_fundamental_V * i_q / float(np.mean(np.abs(i)))
    return _ACROSS * abs(across_V / of.omega_e_rad_s)


def _rounded_Wb(of: TurningFlux, known: Known) -> float:
    """Return what the fundamental of that voltage may be off by, as a flux."""
    return _ROUNDED * abs(known.drop_fundamental_V / of.omega_e_rad_s)


def _mean_rounded_Wb(turning: Sequence[TurningFlux], known: Known) -> float:
    return float(np.mean([_rounded_Wb(each, known) for each in turning]))


def _stretches(rows: int, known: Known) -> tuple[tuple[int, int], ...]:
    """Return the rows of each level of the current along the rotor flux, from where it has settled."""
    bandwidth = at_speed(known)["omega_current"]
    assert isinstance(bandwidth, float)
    level = rows / _LEVELS
    settled = min(math.ceil(_SETTLED / (bandwidth * known.control_period_s)), math.floor(0.5 * level))
    return tuple((math.ceil(k * level) + settled, math.floor((k + 1) * level) - 1) for k in range(_LEVELS))
