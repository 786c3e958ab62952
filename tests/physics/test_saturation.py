"""Saturation and cross-coupling, against a machine made of the energy of its field: see `saturated`."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import given, strategies as st

from benchtool.emulator.core import Core
from benchtool.emulator.core.kernel import run_ticks
from benchtool.emulator.machine.coefficients import fastest_rate
from benchtool.emulator.machine.plant import airgap_torque, current_rates, step
from benchtool.emulator.machine.saturation import (
    Flux,
    SaturationTruth,
    currents_of,
    field_energy,
    flux_at,
    incremental,
)
from benchtool.emulator.machine.state import place
from benchtool.emulator.machine.truth import MotorTruth
from benchtool.errors import EmulationError, ValueRefused
from tests.physics.alpha_beta import OFF
from tests.physics.paper_machine import make_core
from tests.physics.saturated import Saturated
from tests.physics.test_asymmetry import MOTOR, NO_TRIP, PHASE, T_S, WIDE, over_duties, run_duties, state_of

# Of the order of a machine of 0.12 Wb and 4 mH and 9 mH: half of the inductance is left at 20 A.
MADE: dict[str, Any] = {"a_dd": 1.2e5, "a_qq": 4000.0, "a_dq": 2.5e5, "S": 4, "T": 2, "U": 1, "V": 1}
SYMMETRIC: dict[str, Any] = {
    key: value
    for key, value in MOTOR.items()
    if not key.startswith(("psi_1", "psi_5", "psi_7", "psi_o", "s"))
}
PSI_R, L_D, L_Q = 0.12, 4e-3, 9e-3


def energy(psi_d: complex, psi_q: complex) -> complex:
    """The energy as a polynomial in squares, with the inductances and the flux of no current given."""
    d, q = psi_d * psi_d, psi_q * psi_q
    a_d = 1.0 / L_D - 5 * 1.2e5 * PSI_R**4
    i_f = (a_d + 1.2e5 * PSI_R**4) * PSI_R
    along = a_d * d / 2 + 1.2e5 * d**3 / 6 - i_f * psi_d
    across = q / L_Q / 2 + 4000.0 * q**2 / 4
    return along + across + 2.5e5 / 9 * (d * q) ** 1.5


def reference(**given: Any) -> Saturated:
    return Saturated(p=3, R=0.3, L_d=L_D, L_q=L_Q, harmonics={1: PSI_R}, J=8e-4, energy=energy, **given)


def core_with(motor: dict[str, Any], inverter: dict[str, Any], i_d: float, i_q: float, omega: float) -> Core:
    motor = {**motor, "saturation": SaturationTruth(**MADE)}
    core = make_core(motor=motor, inverter=inverter, sensors=WIDE, parameters=NO_TRIP)
    core.shaft.i_d, core.shaft.i_q, core.shaft.omega_m = i_d, i_q, omega
    return core


MACHINE = MotorTruth(**SYMMETRIC, saturation=SaturationTruth(**MADE)).machine()
SATURATION = SaturationTruth(**MADE).coefficients(L_D, L_Q, PSI_R)


def test_without_current_the_machine_is_that_of_the_profile() -> None:
    flux = flux_at(SATURATION, 0.0, 0.0, None)
    assert flux == pytest.approx((PSI_R, 0.0), abs=1e-15)
    G = incremental(SATURATION, *flux)
    assert (1.0 / G.dd, G.dq, 1.0 / G.qq) == pytest.approx((L_D, 0.0, L_Q), rel=1e-12)


@given(psi_d=st.floats(-0.2, 0.25), psi_q=st.floats(-0.25, 0.25))
def test_the_map_is_reciprocal_and_has_an_inverse(psi_d: float, psi_q: float) -> None:
    i_d, i_q = currents_of(SATURATION, psi_d, psi_q)
    assert (i_d, i_q) == pytest.approx(tuple(reference().gradient(np.array([psi_d, psi_q]))), abs=1e-9)
    h = 1e-6
    ahead, behind = currents_of(SATURATION, psi_d, psi_q + h), currents_of(SATURATION, psi_d, psi_q - h)
    across = (ahead[0] - behind[0]) / (2 * h)
    ahead, behind = currents_of(SATURATION, psi_d + h, psi_q), currents_of(SATURATION, psi_d - h, psi_q)
    assert (ahead[1] - behind[1]) / (2 * h) == pytest.approx(across, abs=1e-4)
    assert incremental(SATURATION, psi_d, psi_q).dq == pytest.approx(across, abs=1e-4)
    assert flux_at(SATURATION, i_d, i_q, Flux(0.0, 0.0)) == pytest.approx((psi_d, psi_q), abs=1e-12)
    stored = energy(psi_d, psi_q) - energy(PSI_R, 0.0)
    assert field_energy(SATURATION, Flux(psi_d, psi_q)) == pytest.approx(stored, abs=1e-12)


def test_half_of_the_inductance_is_left_at_high_currents() -> None:
    """The flux of 20 A along q is well below L_q i_q, and less with current along d as well."""
    alone, crossed = flux_at(SATURATION, 0.0, 20.0, None), flux_at(SATURATION, 20.0, 20.0, None)
    assert 0.5 < alone.psi_q / (L_Q * 20.0) < 0.8
    assert crossed.psi_q < 0.95 * alone.psi_q


@pytest.mark.parametrize("differ", [False, True], ids=["alike", "phases differ"])
def test_agrees_with_a_machine_of_field_energy(differ: bool) -> None:
    duties = np.random.default_rng(3).choice([0.0, 1.0, 0.5, 0.7, 0.3], (4, 3))
    series = {"series_R_ohm": PHASE["series_R"], "series_L_H": PHASE["series_L"]} if differ else {}
    core = core_with({**SYMMETRIC, **series}, {"u_dc_V": 300.0}, 12.0, -9.0, 60.0)
    run_duties(core, duties)
    other = reference(
        u_dc=300.0, **{"series_R": PHASE["series_R"], "series_L": PHASE["series_L"]} if differ else {}
    )
    y = over_duties(other, other.state(12.0, -9.0, 60.0, 0.0), duties, 0.0)
    assert state_of(core) == pytest.approx((*other.dq(y), y[2], y[3]), abs=1e-7, rel=1e-7)
    assert flux_at(SATURATION, core.shaft.i_d, core.shaft.i_q, None) == pytest.approx(
        (core.shaft.psi_d, core.shaft.psi_q), abs=1e-12
    )


def test_rectifies_as_a_machine_of_field_energy_does() -> None:
    core = core_with(SYMMETRIC, {"u_dc_V": 60.0, "device_drop_V": 0.8}, 0.0, 0.0, 500.0)
    core.load.held, core.load.omega_m_rad_s = 1, 500.0
    core.run_with(run_ticks, 8)
    other = reference(u_dc=60.0, drop=0.8, held=True)
    y = other.state(0.0, 0.0, 500.0, 0.0)
    for k in range(8):
        y = other.run(y, (k * T_S, (k + 1) * T_S), (OFF, OFF, OFF))
    assert state_of(core)[:2] == pytest.approx(other.dq(y), abs=5e-3)
    assert abs(core.shaft.i_d) > 2.0


def test_torque_is_the_slope_of_the_coenergy() -> None:
    for i_d, i_q in ((0.0, 5.0), (-12.0, 9.0), (15.0, -20.0)):
        flux = flux_at(SATURATION, i_d, i_q, None)
        expected = reference().torque(np.array([i_d, i_q]), 0.0)
        assert airgap_torque(*flux, 0.0, MACHINE) == pytest.approx(expected, abs=1e-6)


def test_rates_of_the_currents_are_those_of_a_step() -> None:
    x = place(12.0, -9.0, 200.0, 0.4, flux_at(SATURATION, 12.0, -9.0, None))
    di_d, di_q = current_rates(x, 100.0, -50.0, MACHINE)
    h = 1e-7
    ahead, behind = (step(x, 100.0, -50.0, each, MACHINE, 0.0) for each in (h, -h))
    assert (di_d, di_q) == pytest.approx(
        ((ahead.i_d - behind.i_d) / (2 * h), (ahead.i_q - behind.i_q) / (2 * h)), rel=1e-6
    )


def test_a_saturated_machine_is_a_faster_one() -> None:
    rates = [
        fastest_rate(MACHINE, place(0.0, i_q, 0.0, 0.0, flux_at(SATURATION, 0.0, i_q, None)))
        for i_q in (0.0, 40.0)
    ]
    assert rates[1] > 1.3 * rates[0]


def test_a_machine_that_saturates_without_current_is_refused() -> None:
    with pytest.raises(ValueRefused, match="a_dd"):
        MotorTruth(**SYMMETRIC, saturation=SaturationTruth(a_dd=1e9)).machine()


def test_a_run_ends_where_the_map_has_no_inverse() -> None:
    """Cross-coupling alone, far beyond the currents that it was fitted to."""
    motor = {**SYMMETRIC, "saturation": SaturationTruth(a_dq=1e4, U=0, V=0)}
    core = make_core(motor=motor, sensors=WIDE, parameters=NO_TRIP)
    core.shaft.psi_d, core.shaft.psi_q = 0.5, 0.5
    core.shaft.i_d, core.shaft.i_q = currents_of(MotorTruth(**motor).machine().saturation, 0.5, 0.5)
    with pytest.raises(EmulationError, match="saturation"):
        core.run_with(run_ticks, 10)
