"""What one control tick leaves in the drive's memory: the flux vector, standing by, voltages beyond reach."""

from __future__ import annotations

import cmath
from typing import Any

import numpy as np
import pytest

from benchtool.emulator.control.laws import Law, demand, reset_law
from benchtool.emulator.control.stimulus import Quantity, Shape, StimulusState
from benchtool.emulator.control.vectors import MODULATED
from benchtool.emulator.memory import CONTROL
from benchtool.protocol.modes import Mode
from tests.physics.paper_machine import FINE, MOTOR, make_core
from tests.physics.test_laws import at

REFERENCES = ("u_alpha", "u_beta", "torque_reference", "psi_s_reference", "law_angle", "stimulus")
OF_THE_LAWS = (
    *("limited", "torque_state", "flux_state", "flux_error_sum", "delta_integral"),
    *("u_d_integral", "u_q_integral", "u_alpha_asked", "u_beta_asked"),
)


def signal(core: Any, name: str) -> float:
    return float(core.memory[name][0])


def stimulated(core: Any, quantity: Quantity, amplitude: float) -> None:
    """Play a constant for longer than any test."""
    stimulus = core.stimulus
    stimulus.quantity, stimulus.kind, stimulus.amplitude = int(quantity), int(Shape.CONSTANT), amplitude
    stimulus.ticks, stimulus.repetitions, stimulus.steps, stimulus.T_s = 100_000, 1, 1, 1e-4
    stimulus.cos_angle, stimulus.sin_angle = 0.8, 0.6
    stimulus.state = int(StimulusState.RUNNING)


@pytest.mark.parametrize("theta_e", [0.4, 2.0, 4.4])
def test_the_flux_vector_is_that_of_currents_and_rotor_in_the_stator(theta_e: float) -> None:
    """psi_s = L i_s + psi_r exp(j theta_e), from the signals of the same tick and the amplitude-invariant
    sum of the phase currents."""
    core = make_core(sensors=FINE)
    core.turn_rotor(theta_e)
    core.load.held = 1
    core.command.pwm_enabled = 1
    core.memory["torque_command"] = 3.0
    core.run(40)
    phases = [signal(core, f"i_{phase}") for phase in "abc"]
    i_s = 2.0 / 3.0 * sum(i * cmath.exp(2j * cmath.pi * k / 3.0) for k, i in enumerate(phases))
    assert abs(i_s) > 1.0
    psi_s = MOTOR["L_d_H"] * i_s + MOTOR["psi_r_Wb"] * cmath.exp(4j * signal(core, "theta_m"))
    assert complex(signal(core, "psi_alpha"), signal(core, "psi_beta")) == pytest.approx(psi_s, abs=1e-6)
    assert signal(core, "psi_s") == pytest.approx(abs(psi_s), abs=1e-6)


def test_standing_by_nothing_is_asked_for_and_nothing_is_remembered() -> None:
    core = make_core(parameters={"law": int(Law.SVM_DTC)})
    core.command.mode, core.command.pwm_enabled = int(Mode.VELOCITY), 1
    core.memory["omega_m_command"] = 30.0
    stimulated(core, Quantity.SPEED, 5.0)
    core.run(300)
    assert all(signal(core, name) != 0.0 for name in REFERENCES)
    for name in (*OF_THE_LAWS, "speed_integral", "braking", "gated", "gated_next"):
        core._controls[name] = 1
    core.command.standstill = 1
    core.command.pwm_enabled = 0
    core.run(1)
    assert {name: signal(core, name) for name in REFERENCES} == dict.fromkeys(REFERENCES, 0.0)
    cleared = (
        *OF_THE_LAWS,
        "speed_integral",
        "braking",
        "gated",
        "gated_next",
        "u_alpha_next",
        "u_beta_next",
    )
    assert {name: float(core._controls[name][0]) for name in cleared} == dict.fromkeys(cleared, 0.0)
    assert core.command.standstill == 0


def test_what_a_quick_stop_came_to_is_there_after_the_power_stage_went_off() -> None:
    core = make_core()
    core.command.quick_stop = core.command.standstill = 1
    core.run(1)
    assert core.command.standstill == 1


def test_a_voltage_in_the_rotors_frame_lies_along_the_rotor_flux() -> None:
    core = make_core(sensors=FINE)
    core.turn_rotor(2.2)
    core.load.held = 1
    core.command.mode, core.command.pwm_enabled = int(Mode.VOLTAGE), 1
    stimulated(core, Quantity.VOLTAGE, 20.0)
    core.stimulus.in_rotor_frame = 1
    core.run(5)
    made = complex(signal(core, "u_alpha"), signal(core, "u_beta"))
    assert made == pytest.approx(20.0 * cmath.exp(2.2j), abs=0.01)


@pytest.mark.parametrize(("u", "clipped"), [(60.0, 0), (400.0, 10)])
def test_a_voltage_beyond_the_hexagon_counts_as_clipped_in_every_tick(u: float, clipped: int) -> None:
    core = make_core(parameters={"i_trip": 14.4})
    core.load.held = 1
    core.command.mode, core.command.pwm_enabled = int(Mode.VOLTAGE), 1
    core._controls["speed_integral"] = 1.0
    for name in OF_THE_LAWS:
        core._controls[name] = 1
    for name in ("torque_reference", "psi_s_reference", "law_angle"):
        core.memory[name] = 1.0
    before = signal(core, "law_clipped")
    stimulated(core, Quantity.VOLTAGE, u)
    core.run(10)
    assert core.command.trip == 0
    assert signal(core, "law_clipped") - before == clipped
    made = complex(signal(core, "u_alpha"), signal(core, "u_beta"))
    assert cmath.phase(made) == pytest.approx(cmath.phase(0.8 + 0.6j), abs=1e-6)
    assert abs(made) == pytest.approx(u, rel=1e-6) if not clipped else abs(made) < 2.0 / 3.0 * 122.6
    kept = ("speed_integral", *(name for name in OF_THE_LAWS if name != "limited"))
    assert {name: float(core._controls[name][0]) for name in kept} == dict.fromkeys(kept, 0.0)
    assert {signal(core, name) for name in ("torque_reference", "psi_s_reference", "law_angle")} == {0.0}


def test_forgetting_clears_all_that_the_laws_remember_and_nothing_else() -> None:
    control: Any = np.zeros(1, CONTROL)
    for name in control.dtype.names:
        control[name] = 1
    reset_law(control[0])
    assert {name for name in control.dtype.names if control[name][0] == 0} == set(OF_THE_LAWS)


def test_an_unknown_law_makes_no_voltage_and_counts_as_clipped() -> None:
    memory = make_core(parameters={"law": max(Law) + 1, "u_dc": 122.5}).memory[0]
    asked = demand(at(0.1, 1.0, 63.0, memory), 1.0, 0.17, memory, np.zeros(1, CONTROL)[0])
    assert (asked.u_alpha, asked.u_beta, asked.vector, asked.clipped) == (0.0, 0.0, MODULATED, True)


def test_parameters_that_make_no_number_make_no_voltage_and_count_as_clipped() -> None:
    memory = make_core(parameters={"law": int(Law.TPC), "u_dc": 122.5, "R_s": cmath.nan}).memory[0]
    control = np.zeros(1, CONTROL)[0]
    control.flux_error_sum = 1.0
    asked = demand(at(0.1, 1.0, 63.0, memory), 1.0, 0.17, memory, control)
    assert asked == (0.0, 0.0, MODULATED, 0.0, True)
    assert control.flux_error_sum == 0.0
