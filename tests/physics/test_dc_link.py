"""The dc link as a capacitor: against scipy, and in the loop: braking pumps it up, the chopper holds it."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import assume, given, settings, strategies as st
from scipy.integrate import solve_ivp

from benchtool.emulator.core import Core, Trip
from benchtool.emulator.machine.dc_link import charged, giving
from benchtool.emulator.machine.train_truth import FlangeTruth, LoadTruth, ShaftTruth, TrainTruth
from benchtool.emulator.machine.truth import InverterTruth
from benchtool.errors import ValueRefused
from tests.physics.paper_machine import FINE, captured, make_core

LINK: dict[str, Any] = {"u_dc_V": 122.5, "dc_link_R_ohm": 0.5, "dc_link_C_F": 1e-3}
# Too small to be felt: with the parts of tests/physics/test_flange the kernel is that one.
UNFELT: dict[str, Any] = {
    "motor": {"cogging_Nm": (1e-12, 1e-12), "cogging_order": (24, 48), "coulomb_Nm": 1e-12},
    "train": TrainTruth(
        shaft=ShaftTruth(J_load_kgm2=1e-12), load=LoadTruth(linear_Nms=1e-12), flange=FlangeTruth()
    ),
}


CIRCUITS: dict[str, st.SearchStrategy[float]] = {
    "u": st.floats(50.0, 200.0),
    "u_s": st.floats(50.0, 200.0),
    "R": st.floats(0.05, 50.0),
    "G": st.just(0.0) | st.floats(0.001, 0.5),
}


@settings(max_examples=60, deadline=None)
@given(
    C=st.floats(1e-5, 1e-2),
    **CIRCUITS,
    current=st.just(0.0) | st.floats(-30.0, 30.0),
)
def test_the_closed_form_is_the_solution_of_the_equation(
    C: float, u: float, u_s: float, R: float, G: float, current: float
) -> None:
    def rates(_: float, x: np.ndarray[Any, Any]) -> Any:
        fed = np.maximum(u_s - x[0], 0.0) / R
        return [(fed - G * x[0] - current) / C, x[0], fed, R * fed * fed, G * x[0] * x[0]]

    start = [u, 0.0, 0.0, 0.0, 0.0]
    exact = solve_ivp(rates, (0.0, 1e-4), start, "LSODA", rtol=1e-10, atol=1e-12, max_step=2e-6).y[:, -1]
    found = charged(C, u, u_s, 1.0 / R, G, current, 1e-4)
    assert found.u == pytest.approx(max(exact[0], 0.0), abs=1e-6)
    assert found[1:5] == pytest.approx(exact[1:], rel=1e-6, abs=1e-9)
    if found.u > 0.0:
        stored = 0.5 * C * (found.u**2 - u**2)
        moved = abs(u_s * found.fed) + found.lost + found.burnt + abs(current * found.area) + abs(stored)
        left = u_s * found.fed - found.lost - found.burnt - current * found.area - stored
        assert abs(left) <= 1e-11 * moved + 1e-15 * C * u**2


@settings(max_examples=60, deadline=None)
@given(
    C=st.floats(1e-4, 1e-2),
    **CIRCUITS,
    power_W=st.floats(-2000.0, 2000.0),
)
def test_the_capacitor_gives_the_energy_that_the_legs_took(
    C: float, u: float, u_s: float, R: float, G: float, power_W: float
) -> None:
    # beyond what it holds, less what the chopper takes, there is no such current
    assume(1e-4 * (power_W + G * u**2) < 0.499 * C * u**2)
    found = giving(C, u, u_s, 1.0 / R, G, 1e-4 * power_W, 1e-4)
    given_J = u_s * found.fed - found.lost - found.burnt - 0.5 * C * (found.u**2 - u**2)
    moved = abs(u_s * found.fed) + found.lost + found.burnt + 1e-4 * abs(power_W) + C * abs(found.u**2 - u**2)
    assert abs(given_J - 1e-4 * power_W) <= 1e-11 * moved + 1e-15 * C * u**2
    if found.u > 0.0:
        drawn = charged(C, u, u_s, 1.0 / R, G, 1e-4 * power_W / found.area, 1e-4)
        assert found == pytest.approx(drawn, rel=1e-9, abs=1e-9)


@settings(max_examples=60, deadline=None)
@given(
    C=st.floats(1e-5, 1e-2),
    **CIRCUITS,
    more=st.floats(1.1, 10.0),
)
def test_a_capacitor_that_is_asked_for_more_than_it_holds_is_empty(
    C: float, u: float, u_s: float, R: float, G: float, more: float
) -> None:
    fed_J = 1e-4 * u_s**2 / R
    found = giving(C, u, u_s, 1.0 / R, G, more * (0.5 * C * u**2 + fed_J), 1e-4)
    assert found.u == pytest.approx(0.0, abs=1e-9 * u)
    given_J = u_s * found.fed - found.lost - found.burnt + 0.5 * C * u**2
    assert 0.0 < given_J <= 0.5 * C * u**2 + fed_J


def braking(**inverter: float) -> Core:
    """4 Nm against 150 rad/s of a load machine: some 560 W back into the link."""
    core = make_core(
        inverter={**LINK, "u_dc_V": 250.0, **inverter},
        sensors=FINE,
        parameters={"u_dc_max": 300.0, "u_s": 150.0},
        **UNFELT,
    )
    core.load.held, core.load.omega_m_rad_s = 1, 150.0
    core.memory["torque_command"] = -4.0
    core.command.pwm_enabled = 1
    return core


def test_braking_pumps_the_link_up_until_it_trips() -> None:
    """The energy of the braking, less the copper's, is in the capacitor."""
    core = braking()
    core.run(100)
    u_start, t_start = float(core.shaft.u_dc), core.tick
    assert core.run(2000) < 2000
    assert core.command.trip == Trip.OVERVOLTAGE
    stored = 0.5 * 1e-3 * (float(core.shaft.u_dc) ** 2 - u_start**2)
    copper = 1.5 * 0.123 * (4.0 / (1.5 * 4 * 0.1685)) ** 2
    assert stored == pytest.approx((4.0 * 150.0 - copper) * (core.tick - t_start) * 1e-4, rel=0.03)


def test_the_chopper_holds_the_link_between_its_levels() -> None:
    core = braking(chopper_R_ohm=50.0, chopper_on_V=290.0, chopper_off_V=280.0)
    assert core.run(3000) == 3000
    u_dc = captured(core, ["u_dc"], 3000)["u_dc"]
    assert 278.0 < u_dc.min() < 281.5
    assert 288.5 < u_dc.max() < 292.0


def test_the_supplys_ripple_is_on_the_link() -> None:
    """Resistance and capacitor are a low pass of 318 Hz, as long as the supply feeds all the time."""
    ripple = {"supply_ripple_V": 1.0, "supply_ripple_Hz": 320.0}
    core = make_core(inverter={**LINK, **ripple}, sensors=FINE, **UNFELT)
    core.load.held, core.load.omega_m_rad_s = 1, 60.0
    core.memory["torque_command"] = 8.0  # 490 W: 4 A, of which the ripple takes 1.4 A
    core.command.pwm_enabled = 1
    core.run(2000)
    u_dc = captured(core, ["u_dc"], 5000)["u_dc"]  # 160 periods
    amplitude = abs(2.0 * np.mean(u_dc * np.exp(-2j * math.pi * 320.0 * 1e-4 * np.arange(5000))))
    assert amplitude == pytest.approx(1.0 / math.hypot(1.0, 2.0 * math.pi * 320.0 * 0.5e-3), rel=0.03)


def test_a_diode_rectifier_of_the_machine_charges_the_link() -> None:
    """Held at rated speed with the stage off the link rises to the peak of the line EMF, and stays."""
    core = make_core(inverter=LINK, sensors=FINE, parameters={"u_dc_max": 400.0}, **UNFELT)
    core.load.held, core.load.omega_m_rad_s = 1, 157.1
    core.run(20_000)
    peak = math.sqrt(3.0) * 0.1685 * 4 * 157.1
    assert float(core.shaft.u_dc) == pytest.approx(peak, rel=0.01)
    assert abs(float(core.shaft.i_q)) < 0.05


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"dc_link_R_ohm": 0.0}, "dc_link_R_ohm"),
        ({"dc_link_C_F": 0.0, "supply_ripple_V": 1.0}, "supply_ripple_V"),
        ({"chopper_R_ohm": 10.0, "chopper_on_V": 130.0, "chopper_off_V": 120.0}, "chopper_off_V"),
    ],
)
def test_what_makes_no_sense_is_refused_by_its_key(change: dict[str, float], named: str) -> None:
    with pytest.raises(ValueRefused, match=named):
        InverterTruth(**{**LINK, **change})
