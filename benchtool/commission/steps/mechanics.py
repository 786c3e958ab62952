"""Inertia, Coulomb and viscous friction, by reversing the shaft between constant speeds."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping, Sequence
from typing import Final

import numpy as np

from benchtool.analysis import Basis, Contribution, Measurement, Uncertainty, combined, sure_of
from benchtool.block import Block
from benchtool.commission.estimators.cogging import Cogging, cogging, without
from benchtool.commission.estimators.mechanics import Course, Mechanics, mechanics
from benchtool.commission.estimators.vectors import vector_of
from benchtool.commission.excitation import Excitation
from benchtool.commission.known import Known
from benchtool.commission.steps.offsets import CURRENTS
from benchtool.commission.steps.speed_loop import at_speed, settling_s
from benchtool.commission.steps.step import Finding
from benchtool.drive import CaptureRequest, Stimulus

_SPEEDS = (0.12, 0.2, 0.28, 0.36)  # of the rated speed; the drive trips at half of it
_LEVELS = 3  # a binary sequence of three bits: on, back, on
_LEAST_S, _REVOLUTIONS = 0.2, 2.15  # of a steady stretch: of one, what comes once in it looks like a drift
_SWINGS = 15.0  # of J / K_p, until a speed no longer swings
_ROWS = 20_000  # so that the torque that reverses the shaft leaps between two of many
_LEFT_OUT_J = 0.005
_ROUNDS = 5
_LEAST_COGGING, _MOST_ORDERS, _LEFT_OUT_COGGING = 0.001, 4, 0.05  # of the rated torque; relative
_LEFT_OUT_NM = 2e-4  # of the rated torque, that is no friction
_FACTOR = 2.0
_TOLD: Final[Mapping[str, float]] = {"J": 0.05, "coulomb": 0.09, "friction": 0.14}
"""Largest relative expanded uncertainty of an estimate that is given."""
_LOAD_SHARE = 0.02
_RUBS = 0.13  # of the rated torque: friction beyond it is a load


class Reversals:
    """Turn on, back and on again at four speeds, under speed control."""

    name = "mechanics"
    needs: tuple[str, ...] = ("flux_linkage",)
    sets: tuple[str, ...] = ("J", "coulomb", "friction")

    def plan(self, known: Known) -> tuple[Excitation, ...]:
        """Return a sequence of three speeds for each size; none where the shaft may not turn round."""
        if math.isfinite(known.travel_rad):
            return ()
        found = []
        for share in _SPEEDS:
            omega = share * known.motor.omega_m_N_rad_s
            level_s = _level_s(known, omega)
            stride = max(1, math.ceil(_LEVELS * level_s / (_ROWS * known.control_period_s)))
            rows = math.floor(_LEVELS * level_s / (stride * known.control_period_s))
            torque = 1.5 * known.identified.pole_pairs * known.identified.psi_r_Wb
            accelerating = 5.0 * known.identified.J_kgm2 * omega * 0.5 * known.motor.T_N_Nm / torque**2
            found.append(
                Excitation(
                    f"{omega:.3g} rad/s on, back and on",
                    Stimulus(
                        quantity="speed",
                        shape="prbs",
                        amplitude_rad_s=omega,
                        prbs_clock_s=level_s,
                        prbs_length=2,
                        seed=1,
                    ),
                    CaptureRequest((*CURRENTS, "theta_m"), rows=rows, stride=stride),
                    accelerating,
                    at_speed(known),
                )
            )
        return tuple(found)

    def estimate(self, blocks: Sequence[Block], known: Known) -> Mapping[str, Measurement]:
        """Return `J`, `coulomb` and `friction`.

        Raises:
            AnalysisError: the shaft does not hold its speeds.
        """
        if not blocks:
            reason = f"the shaft may turn {known.travel_rad:.3g} rad only"
            return {
                name: Measurement.undefined(name, unit, definition, reason)
                for name, (unit, definition) in _DEFINITIONS.items()
            }
        courses = [_course(block, known, share) for block, share in zip(blocks, _SPEEDS, strict=True)]
        found: Mechanics = mechanics(courses)
        orders: tuple[Cogging, ...] = ()
        for _ in range(_ROUNDS):  # the inertia tells the cogging, and that the inertia
            orders = _told(courses, found, known)
            found = mechanics(without(courses, orders))
        estimates = (*_measurements(found, blocks, known), *_cogging(orders))
        return {each.name: each for each in estimates}

    def findings(self, found: Mapping[str, Measurement], known: Known) -> tuple[Finding, ...]:
        """Return what the shaft says of the set-up."""
        findings: list[Finding] = []
        if "inertia_ratio" not in found:  # the shaft did not turn
            return ()
        times = found["inertia_ratio"]
        unsure = sure_of(times.uncertainty)
        if times.value - unsure > _FACTOR or times.value + unsure < 1.0 / _FACTOR:
            J = times.value * known.motor.J_kgm2
            findings.append(
                Finding(
                    f"the inertia is {J:.4g} kgm2, {times.value:.3g} times the nameplate's",
                    "a load on the shaft"
                    if times.value > 1.0
                    else "another rotor, or an inertia stated with a load",
                    "uncouple the load to commission the motor alone, or state its inertia in motor.J_kgm2",
                    fails=False,
                )
            )
        rubs_Nm = found["friction_torque"].value
        if rubs_Nm > _RUBS * known.motor.T_N_Nm:
            findings.append(
                Finding(
                    f"friction takes {rubs_Nm:.4g} Nm at {_SPEEDS[-1]:.0%} of the rated speed, "
                    f"{rubs_Nm / known.motor.T_N_Nm:.0%} of the rated torque",
                    "a load on the shaft, or a bearing or brake that rubs",
                    "uncouple the load and release the brake to commission the motor alone",
                    fails=False,
                )
            )
        load = found["load"]
        least = _LOAD_SHARE * known.motor.T_N_Nm
        if abs(load.value) > max(least, sure_of(load.uncertainty)):
            findings.append(
                Finding(
                    f"a torque of {load.value:.4g} Nm turns the shaft one way",
                    "a load on the shaft, such as a weight or a spring, or a load machine that is enabled",
                    "uncouple the load: it moves the encoder's offset, too",
                )
            )
        return tuple(findings)


def _level_s(known: Known, omega: float) -> float:
    """Return how long a speed is held: until it is settled, and a steady stretch.

    A rotor of more inertia than the nameplate's swings about the speed before it holds it.
    """
    gain = at_speed(known)["K_p_speed"]
    assert isinstance(gain, float)
    swings_s = _SWINGS * known.identified.J_kgm2 / gain
    return settling_s(known, 2.0 * omega) + swings_s + max(_LEAST_S, _REVOLUTIONS * 2.0 * math.pi / omega)


def _course(block: Block, known: Known, share: float) -> Course:
    """Return angle and torque of a capture; the drive has corrected its currents."""
    omega = share * known.motor.omega_m_N_rad_s
    motor = known.identified
    theta = known.without_eccentricity(np.unwrap(block.column("theta_m")))
    i = vector_of(np.column_stack([block.column(name) for name in CURRENTS]))
    i_dq = i * np.exp(-1j * motor.pole_pairs * theta)
    flux = motor.psi_r_Wb + (motor.L_d_H - motor.L_q_H) * i_dq.real
    torque = 1.5 * motor.pole_pairs * flux * i_dq.imag
    for order, psi in known.flux_harmonics.items():  # currents that they drive brake the shaft
        of_angle = 1j * order * psi * np.exp(1j * order * motor.pole_pairs * theta)
        torque += 1.5 * motor.pole_pairs * (of_angle * np.conj(i)).real
    step_s = block.tick_s * block.stride
    level = _level_s(known, omega) / step_s
    steady_s = max(_LEAST_S, _REVOLUTIONS * 2.0 * math.pi / omega)
    ends = tuple(min(len(theta), math.floor(k * level)) for k in range(1, _LEVELS + 1))
    return Course(theta, torque, step_s, ends, math.floor(steady_s / step_s))


_DEFINITIONS: Final = {
    "J": ("kgm2", "impulse of the torque over the change of speed, between constant speeds"),
    "coulomb": ("Nm", "torque at constant speeds that changes its sign with the direction"),
    "friction": ("Nms", "torque at constant speeds that grows with the speed"),
}


def _told(courses: Sequence[Course], found: Mechanics, known: Known) -> tuple[Cogging, ...]:
    """Return the orders of cogging that are told, at most four."""
    thinned = [each.thinned for each in courses]
    return cogging(thinned, found.J_kgm2, _LEAST_COGGING * known.motor.T_N_Nm)[:_MOST_ORDERS]


def _cogging(orders: Sequence[Cogging]) -> Iterator[Measurement]:
    """Yield the amplitude of each order of cogging that is told; else why none is."""
    for each in orders:
        lines = [
            Contribution("scatter over speeds and directions", "A", each.standard_Nm, each.dof),
            Contribution(
                "what the rows resolve", "B", _LEFT_OUT_COGGING * each.amplitude_Nm / math.sqrt(3.0)
            ),
        ]
        yield Measurement(
            f"cogging_{each.order}",
            each.amplitude_Nm,
            "Nm",
            f"amplitude of the torque that comes {each.order} times in a revolution, at standing angles",
            Basis(order=each.order),
            uncertainty=combined(lines, "scatter over speeds and directions"),
        )
    if not orders:
        reason = f"no order above {_LEAST_COGGING:.1%} of the rated torque stands out of the scatter"
        definition = "amplitude of the cogging torque by its order"
        yield Measurement.undefined("cogging", "Nm", definition, reason)


def _late_Nms(known: Known) -> float:
    """Return the standard uncertainty of the torque over the speed by the moment of sampling.

    Dead time and devices move the pulses by up to half of the time that their voltage takes, and meanwhile
    the EMF changes i_q.
    """
    motor = known.identified
    late_s = 0.5 * known.drop_V / known.u_dc_V * known.control_period_s
    EMF_Vs = motor.pole_pairs * motor.psi_r_Wb
    return 1.5 * EMF_Vs * EMF_Vs / motor.L_q_H * abs(late_s) / math.sqrt(3.0)


def _measurements(found: Mechanics, blocks: Sequence[Block], known: Known) -> list[Measurement]:
    basis = Basis(samples=sum(len(block.data) for block in blocks))
    psi = known.estimates.get("psi_r")
    of_flux = 0.0
    if psi is not None and psi.uncertainty is not None:
        of_flux = psi.uncertainty.standard / psi.value
    no_friction = _LEFT_OUT_NM * known.motor.T_N_Nm / math.sqrt(3.0)
    slowest, fastest = (share * known.motor.omega_m_N_rad_s for share in (_SPEEDS[0], _SPEEDS[-1]))
    late_Nms = _late_Nms(known)
    estimates = (
        ("J", found.J_kgm2, found.J_standard, found.J_dof, found.J_kgm2 * _LEFT_OUT_J / math.sqrt(3.0), 0.0),
        (
            "coulomb",
            found.coulomb_Nm,
            found.coulomb_standard,
            found.friction_dof,
            no_friction,
            late_Nms * slowest,
        ),
        (
            "friction",
            found.friction_Nms,
            found.friction_standard,
            found.friction_dof,
            no_friction / fastest,
            late_Nms,
        ),
    )
    measured, uncertain = [], dict[str, Uncertainty]()
    for name, value, standard, dof, left_out, late in estimates:
        unit, definition = _DEFINITIONS[name]
        lines = [
            Contribution("scatter over speeds and directions", "A", standard, dof),
            Contribution("rotor flux", "B", abs(value) * of_flux),
            Contribution("what the equation leaves out", "B", left_out),
            Contribution("moment of sampling", "B", late),
        ]
        u = combined([each for each in lines if each.standard > 0.0], "scatter over speeds and directions")
        assert u is not None
        uncertain[name] = u
        if u.expanded > _TOLD[name] * abs(value):
            reason = f"{value:.3g} {unit} with an expanded uncertainty of {u.expanded:.2g}: not determined"
            measured.append(Measurement.undefined(name, unit, definition, reason, basis))
        else:
            measured.append(Measurement(name, value, unit, definition, basis, u))
    u_load = combined([Contribution("scatter", "A", found.load_standard, found.friction_dof)], "scatter")
    definition = "torque at constant speeds that does not depend on the direction"
    rubs_Nm = found.coulomb_Nm + found.friction_Nms * fastest
    of_both = [
        uncertain["coulomb"].line("Coulomb friction"),
        uncertain["friction"].line("viscous friction", fastest),
    ]
    u_rubs = combined(of_both, "Coulomb and viscous friction")
    measured += [
        Measurement("friction_torque", rubs_Nm, "Nm", f"of friction at {fastest:.4g} rad/s", basis, u_rubs),
        Measurement(
            "inertia_ratio",
            found.J_kgm2 / known.motor.J_kgm2,
            "",
            "inertia over the nameplate's",
            basis,
            uncertain["J"].scaled(1.0 / known.motor.J_kgm2),
        ),
    ]
    return [*measured, Measurement("load", found.load_Nm, "Nm", definition, basis, u_load)]
