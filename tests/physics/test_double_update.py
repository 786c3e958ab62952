"""Double update: control at both ends of a PWM period, against a triangular carrier and another inverter.

The kernel runs as plain Python, which needs no compiler for its few periods.
"""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from benchtool.emulator.control.svpwm import compensated
from benchtool.emulator.core.kernel import run_ticks
from benchtool.emulator.machine.carrier import DoubleUpdate, ends_high, pulse, turns_on
from benchtool.errors import ValueRefused
from tests.physics.alpha_beta import gates, in_halves
from tests.physics.paper_machine import make_core
from tests.physics.test_diodes import NO_TRIP, SALIENT, WIDE, reference_of

T_S = 5e-5
UPDATE = DoubleUpdate(2.0 * T_S)


def test_a_leg_is_high_while_its_duty_is_above_a_triangular_carrier() -> None:
    """The carrier falls from 1 to 0 in the first half of the PWM period and rises in the second."""
    duties = np.random.default_rng(1).choice([0.0, 1.0, 0.02, 0.3, 0.5, 0.98], 400)
    part = (np.arange(1000) + 0.5) / 1000.0
    told, counted, high = [], 0, False
    for tick, duty in enumerate(duties):
        carrier = part if tick % 2 else 1.0 - part
        expected = duty > carrier
        rise, fall = pulse(UPDATE, duty, T_S, tick)
        assert ((rise <= part * T_S) & (part * T_S < fall)).tolist() == expected.tolist()
        counted += turns_on(UPDATE, duty, tick, int(high))
        high = ends_high(UPDATE, duty, tick)
        assert high == expected[-1]
        told += expected.tolist()
    assert counted == sum(after and not before for before, after in pairwise([False, *told]))


def test_edges_agree_with_another_inverter_and_its_dead_time() -> None:
    """Duties of 0 and 1 among them; the dead time of one half reaches into the next."""
    rng = np.random.default_rng(2)
    duties = rng.choice([0.0, 1.0, 0.004, 0.5, 0.985, 0.3], (8, 3))
    motor = {**SALIENT, "J_kgm2": 8e-4}
    inverter = {"u_dc_V": 60.0, "dead_time_s": 2e-6, "device_drop_V": 1.2, "double_update": True}
    core = make_core(motor=motor, inverter=inverter, sensors=WIDE, parameters=NO_TRIP, control_period_s=T_S)
    core.shaft.i_d, core.shaft.i_q, core.shaft.omega_m = 0.2, -0.1, 40.0
    core.command.pwm_enabled = 1
    for row in duties:
        core._controls["gated"] = 1
        for name, duty in zip(("duty_a", "duty_b", "duty_c"), row, strict=True):
            core._controls[name] = duty
        assert core.run_with(run_ticks, 1) == 1
    reference, end = reference_of(motor, u_dc=60.0, drop=1.2), len(duties) * T_S
    legs = [gates(in_halves(list(duties[:, k]), T_S), end, 2e-6) for k in range(3)]
    y = reference.follow(reference.state(0.2, -0.1, 40.0, 0.0), legs, end)
    found = (core.shaft.i_d, core.shaft.i_q, core.shaft.omega_m, core.shaft.theta_e)
    assert found == pytest.approx((*reference.dq(y), y[2], y[3]), abs=1e-5)


def test_shunts_in_the_lower_legs_are_refused() -> None:
    with pytest.raises(ValueRefused, match="at the peak of the carrier no lower switch is on"):
        make_core(inverter={"double_update": True}, sensors={"shunt_settling_s": 1e-6})


@pytest.mark.parametrize("current", [3.0, -3.0])
def test_compensation_restores_the_mean_voltage_of_a_pwm_period(current: float) -> None:
    """A large inductance adds up how long the leg was high, with one dead time a PWM period."""
    dead_time = 2e-6
    core = make_core(
        motor={"L_d_H": 10.0, "L_q_H": 10.0, "R_s_ohm": 0.0, "psi_r_Wb": 0.0},
        inverter={"u_dc_V": 100.0, "dead_time_s": dead_time, "double_update": True},
        parameters=NO_TRIP,
        sensors=WIDE,
        control_period_s=T_S,
    )
    assert core.memory["pwm_period"][0] == np.float32(2.0 * T_S)
    core.shaft.i_d, core.command.pwm_enabled = current, 1
    share = dead_time / float(core.memory["pwm_period"][0])
    for duty in (0.3, 0.4, 0.0):
        core._controls["gated"] = 1
        core._controls["duty_a"] = compensated(duty, current, share) if duty else 0.0
        core._controls["duty_b"] = core._controls["duty_c"] = 0.0
        core.run_with(run_ticks, 1)
    high_s = float(core.shaft.i_d - current) * 10.0 / (2.0 / 3.0 * 100.0)
    assert high_s == pytest.approx(0.7 * T_S, rel=1e-6)
