"""Every law where voltage or current do not suffice: on the switching-level machine, above base speed."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray

from benchtool.emulator.control.laws import Law
from benchtool.emulator.core import Core
from benchtool.protocol.modes import Mode
from tests.physics.paper_machine import FINE, captured, make_core
from tests.physics.test_laws_in_the_loop import REAL, TUNED

INTERIOR: dict[str, Any] = {"psi_r_Wb": 0.1, "L_d_H": 4e-3, "L_q_H": 10e-3}
BELIEVED: dict[str, Any] = {"psi_r": 0.1, "L_d": 4e-3, "L_q": 10e-3}
OF_TORQUE = ["torque", "torque_reference", "psi_s", "psi_s_reference", "i_a", "i_b", "i_c", "law_clipped"]
I_TRIP = 12.0
# The earlier TPC leaves out a part of u_s x i_s; one vector per period leaves an offset, most at standstill,
# and the table of dtc one that brakes; the current of foc settles with L / R_s, 77 ms.
OFFSET = {Law.TPC_STATOR: 0.3, Law.DTC: 1.2, Law.FCS_MPC: 0.3, Law.FOC: 0.1}


def core_of(law: Law, u_dc: float, *, interior: bool = False, **parameters: Any) -> Core:
    given = {**TUNED, **(BELIEVED if interior else {}), "law": int(law), "i_trip": I_TRIP, **parameters}
    motor = INTERIOR if interior else None
    return make_core(motor=motor, inverter={"u_dc_V": u_dc}, sensors=REAL, parameters=given)


def brought_to(core: Core, omega_m: float) -> Core:
    """Turned by the load machine from standstill to a held speed, the power stage on."""
    core.load.held = 1
    core.command.pwm_enabled = 1
    for omega in np.linspace(0.0, omega_m, 50):
        core.load.omega_m_rad_s = omega
        core.run(40)
    return core


def after(core: Core, torque: float, ticks: int = 1200) -> dict[str, NDArray[np.float64]]:
    """Signals from a torque step on; the power stage is still on at their end, far from the trip level."""
    core.memory["torque_command"] = torque
    signals = captured(core, OF_TORQUE, ticks)
    assert core.command.trip == 0
    assert max(np.abs(signals[phase]).max() for phase in ("i_a", "i_b", "i_c")) < I_TRIP
    return signals


def settled(signals: dict[str, NDArray[np.float64]], name: str) -> float:
    return float(signals[name][-600:].mean())


@pytest.mark.parametrize("omega_m", [100.0, 157.1])
@pytest.mark.parametrize("law", Law)
def test_every_law_reaches_rated_speed_on_the_profiles_link(law: Law, omega_m: float) -> None:
    """Loaded with 0.65 N·m; its EMF alone, 106 V at rated speed, is above the 71 V that 122.5 V make."""
    core = core_of(law, 122.5)
    core.command.mode, core.command.pwm_enabled = int(Mode.VELOCITY), 1
    core.load.torque_Nm = 0.65
    core.memory["omega_m_command"] = omega_m
    core.run(12_000)
    signals = captured(core, [*OF_TORQUE, "omega_m"], 2000)
    assert core.command.trip == 0
    assert signals["omega_m"].mean() == pytest.approx(omega_m, rel=0.01)
    assert signals["torque"].mean() == pytest.approx(0.65, abs=0.05)
    assert signals["psi_s"].mean() == pytest.approx(signals["psi_s_reference"].mean(), abs=1e-3)
    assert np.abs(signals["i_a"]).max() < I_TRIP


@pytest.mark.parametrize("interior", [False, True], ids=["surface", "interior"])
@pytest.mark.parametrize(
    ("omega_m", "u_dc", "u_s"),
    [(0.0, 122.5, 81.65), (78.6, 122.5, 81.65), (-120.0, 150.0, 100.0), (150.0, 311.0, 90.0)],
)
@pytest.mark.parametrize("law", Law)
def test_a_torque_out_of_reach_leaves_the_flux_and_the_way_back(
    law: Law, omega_m: float, u_dc: float, u_s: float, interior: bool
) -> None:
    core = brought_to(core_of(law, u_dc, interior=interior, u_s=u_s), omega_m)
    offset = OFFSET.get(law, 0.05)
    first = settled(after(core, 0.65), "torque")
    for torque in (9.0, 0.65, -9.0, 0.65):
        signals = after(core, torque)
        asked = settled(signals, "torque_reference")
        assert abs(asked) <= abs(torque) * (1.0 + 1e-6)
        assert settled(signals, "torque") == pytest.approx(asked, abs=offset)
        assert settled(signals, "psi_s") == pytest.approx(settled(signals, "psi_s_reference"), abs=3e-3)
        if torque == 0.65:
            assert asked == pytest.approx(0.65, abs=1e-3)
            assert settled(signals, "torque") == pytest.approx(first, abs=0.3 if law in OFFSET else 0.1)


@pytest.mark.parametrize("law", [law for law in Law if law not in OFFSET])
def test_reachable_torque_above_base_speed_is_made_and_an_unreachable_one_counted(law: Law) -> None:
    core = brought_to(core_of(law, 122.5), 78.6)
    signals = after(core, 9.0)
    assert settled(signals, "torque") == pytest.approx(9.0, abs=0.05)
    core = brought_to(core_of(law, 122.5), 150.0)
    before = int(core.memory["law_clipped"][0])
    after(core, 9.0)
    assert int(core.memory["law_clipped"][0]) - before == 1200


@pytest.mark.parametrize("law", Law)
def test_nothing_is_weakened_where_the_voltage_suffices(law: Law) -> None:
    core = brought_to(core_of(law, 311.0, u_s=200.0), 60.0)
    signals = after(core, 3.0)
    i_q = 3.0 / (6.0 * 0.1685)
    assert signals["psi_s_reference"] == pytest.approx(np.hypot(0.1685, 9.52e-3 * i_q), rel=1e-6)
    assert signals["torque_reference"] == pytest.approx(3.0)


@pytest.mark.parametrize("torque", [0.65, 3.0, 6.0])
def test_tpc_on_the_gradient_has_no_torque_ripple_of_saliency(torque: float) -> None:
    """Counted from psi_r as on a surface-magnet machine, lambda left 0.12, 0.47 and 0.89 N·m."""
    core = make_core(motor=INTERIOR, sensors=FINE, parameters={**TUNED, **BELIEVED})
    core.load.held, core.load.omega_m_rad_s = 1, 15.71
    core.command.pwm_enabled = 1
    core.memory["torque_command"] = torque
    core.run(3000)
    made = captured(core, ["torque"], 2000)["torque"]
    assert np.ptp(made) < 0.012
    assert made.mean() == pytest.approx(torque, abs=0.02)


def test_a_flux_setpoint_gives_way_to_the_voltage_and_says_so() -> None:
    core = brought_to(core_of(Law.FOC, 122.5, psi_s_command=0.2), 20.0)
    assert settled(after(core, 1.0), "psi_s") == pytest.approx(0.2, abs=1e-3)
    assert int(core.memory["law_clipped"][0]) == 0
    core = brought_to(core_of(Law.FOC, 122.5, psi_s_command=0.2), 120.0)
    before = int(core.memory["law_clipped"][0])
    signals = after(core, 1.0, 4000)
    assert settled(signals, "psi_s") == pytest.approx(0.95 * 122.5 / np.sqrt(3) / 480.0, rel=0.01)
    assert settled(signals, "torque") == pytest.approx(1.0, abs=0.02)
    assert int(core.memory["law_clipped"][0]) > before


@pytest.mark.parametrize("law", Law)
def test_speed_that_the_voltage_held_back_does_not_overshoot_for_long(law: Law) -> None:
    """The speed loop's integral stands still while the torque it asks for is out of reach."""
    core = core_of(law, 100.0, u_s=60.0)
    core.command.mode, core.command.pwm_enabled = int(Mode.VELOCITY), 1
    core.memory["omega_m_command"] = 110.0
    core.run(3000)
    core.memory["omega_m_command"] = 30.0
    core.run(10_000)
    speed = captured(core, ["omega_m"], 1000)["omega_m"]
    assert core.command.trip == 0
    assert speed.mean() == pytest.approx(30.0, abs=0.5)
