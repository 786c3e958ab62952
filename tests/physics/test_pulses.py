"""A period of legs with dead time and forward voltages by its moments, against the period edge by edge."""

from __future__ import annotations

from typing import Any

import numpy as np
import pytest
from hypothesis import example, given, strategies as st
from numpy.typing import NDArray

from benchtool.emulator.core import Core
from benchtool.emulator.machine import diodes, pulses, switching
from benchtool.emulator.machine.changes import crossing
from tests.physics.alpha_beta import Reference, centred, gates
from tests.physics.paper_machine import MOTOR, make_core
from tests.physics.test_diodes import NO_TRIP, WIDE, run_period

T_S = 1e-4
IDLE: dict[str, Any] = {"psi_5_Wb": 1e-12}  # has no effect but that periods are computed by their pulses
SALIENT: dict[str, Any] = {
    **IDLE,
    "pole_pairs": 3, "R_s_ohm": 0.3, "L_d_H": 4e-3, "L_q_H": 9e-3, "psi_r_Wb": 0.12, "J_kgm2": 8e-4
}  # fmt: skip
RICH: dict[str, Any] = {
    **MOTOR,
    "psi_5_Wb": 4e-3,
    "psi_7_Wb": 2e-3,
    "cogging_Nm": 0.02,
    "cogging_order": 12,
    "coulomb_Nm": 0.02,
    "breakaway_Nm": 0.03,
    "stribeck_rad_s": 5.0,
}
DEAD_TIME: dict[str, Any] = {"dead_time_s": 2e-6}
DEVICES: dict[str, Any] = {"device_drop_V": 1.0}
LINK: dict[str, Any] = {"dc_link_R_ohm": 0.5, "dc_link_C_F": 1e-3}
BENCHES: dict[str, tuple[dict[str, Any], dict[str, Any]]] = {
    "dead time": ({**MOTOR, **IDLE}, DEAD_TIME),
    "devices": ({**MOTOR, **IDLE}, DEVICES),
    "salient": (SALIENT, {**DEAD_TIME, **DEVICES}),
    "everything": (RICH, {**DEAD_TIME, **DEVICES}),
}


class Period:
    """A random state with duties of one period, on a bench with the inverter's parts."""

    def __init__(self, bench: str, seed: int, current_A: float, T_s: float = T_S) -> None:
        rng = np.random.default_rng(seed)
        self.motor, self.inverter = BENCHES[bench]
        self.amplitude, self.phase = current_A * rng.uniform(0.3, 1.0), rng.uniform(0.0, 6.0)
        self.theta_e, self.omega_m = rng.uniform(0.0, 6.0), 40.0 / self.motor["pole_pairs"]
        self.T_s = T_s
        self.duties = rng.uniform(0.25, 0.75, 3)

    def run(self, *, edges: bool) -> NDArray[np.float64]:
        """(i_d, i_q, omega_m, theta_e, u_dc) after it; a transducer that records asks for the edges."""
        inverter = {**self.inverter, **LINK}
        if "dead_time_s" in inverter:
            inverter["dead_time_s"] *= self.T_s / T_S
        core = make_core(
            motor=self.motor,
            inverter=inverter,
            sensors=WIDE,
            parameters=NO_TRIP,
            control_period_s=self.T_s,
        )
        self.begin(core)
        if edges:
            core.transducer.start(2)
        run_period(core, self.duties)
        return np.array([float(core.shaft[name]) for name in ("i_d", "i_q", "omega_m", "theta_e", "u_dc")])

    def begin(self, core: Core) -> None:
        core.shaft.i_d = self.amplitude * np.cos(self.phase)
        core.shaft.i_q = self.amplitude * np.sin(self.phase)
        core.shaft.omega_m = self.omega_m
        core.turn_rotor(self.theta_e)
        core.load.torque_Nm = 0.4
        core.command.pwm_enabled = 1


@pytest.fixture
def ways(monkeypatch: pytest.MonkeyPatch) -> list[str]:
    """How each period was computed: `followed` from change to change, or `edges` where it could not be."""
    seen: list[str] = []

    def pulsed(*given: Any) -> Any:
        done = pulses.pulsed(*given)
        seen.append("followed" if done[2] else "edges")
        return done

    monkeypatch.setattr(switching, "pulsed", pulsed)
    return seen


@pytest.fixture
def fine(monkeypatch: pytest.MonkeyPatch) -> None:
    """A quarter of the steps between edges, so that what is left is of the moments."""
    monkeypatch.setattr(switching, "_TURN", 0.0125)
    monkeypatch.setattr(diodes, "_TURN", 0.0125)
    monkeypatch.setattr(diodes, "_PARTS", 400)


@pytest.mark.usefixtures("fine")
@pytest.mark.parametrize("bench", BENCHES)
@pytest.mark.parametrize(("current_A", "bound_A"), [(0.5, 1e-4), (20.0, 1e-6)])
def test_a_period_ends_where_short_steps_between_edges_do(
    bench: str, current_A: float, bound_A: float, ways: list[str]
) -> None:
    """Currents through zero, resting there or not, and those that keep their signs."""
    errors = []
    for seed in range(12):
        period = Period(bench, seed, current_A)
        errors.append(np.abs(period.run(edges=False) - period.run(edges=True)))
    assert ways.count("followed") >= 11
    i_d, i_q, omega_m, theta_e, u_dc = np.max(errors, axis=0)
    assert max(i_d, i_q) < bound_A
    assert omega_m < 5e-6
    assert theta_e < 5e-9
    assert u_dc < 2e-5
    assert np.median(errors, axis=0)[:2].max() < 3e-6


@pytest.mark.usefixtures("fine")
@pytest.mark.parametrize("pulse_s", [1e-6, 1.99e-6, 2.01e-6, 3e-6])
@pytest.mark.parametrize("current_A", [1.0, 20.0])
def test_pulses_about_as_short_as_the_dead_time_are_those_of_the_edges(
    pulse_s: float, current_A: float, ways: list[str]
) -> None:
    """Edges that leave a leg where its current holds it, and dead times that outlast the pulse or the
    period."""
    for seed in range(6):
        period = Period("everything", seed, current_A)
        period.duties = np.roll([pulse_s / T_S, 0.5, 1.0 - pulse_s / T_S], seed)
        found = period.run(edges=False)
        assert found == pytest.approx(period.run(edges=True), rel=0.0, abs=1e-4 if current_A < 2.0 else 2e-5)
    assert ways.count("followed") >= 5


@pytest.mark.parametrize("seed", range(4))
def test_a_period_ends_where_another_inverter_in_other_coordinates_does(seed: int, ways: list[str]) -> None:
    period = Period("salient", seed, 1.0)
    core = make_core(
        motor=period.motor, inverter={"u_dc_V": 122.5, **period.inverter}, sensors=WIDE, parameters=NO_TRIP
    )
    period.begin(core)
    run_period(core, period.duties)
    motor = period.motor
    other = Reference(
        p=motor["pole_pairs"],
        R=motor["R_s_ohm"],
        L_d=motor["L_d_H"],
        L_q=motor["L_q_H"],
        harmonics={1: motor["psi_r_Wb"]},
        J=motor["J_kgm2"],
        T_load=0.4,
        u_dc=122.5,
        drop=1.0,
    )
    legs = [gates(centred([duty], T_S), T_S, 2e-6) for duty in period.duties]
    i_d, i_q = period.amplitude * np.cos(period.phase), period.amplitude * np.sin(period.phase)
    y = other.follow(other.state(i_d, i_q, period.omega_m, period.theta_e), legs, T_S)
    assert ways
    assert "edges" not in ways
    found = (core.shaft.i_d, core.shaft.i_q, core.shaft.omega_m, core.shaft.theta_e)
    # the other one has no step at zero current: what rests there it holds within 2e-4 A
    assert found == pytest.approx((*other.dq(y), y[2], y[3]), abs=3e-4)


@pytest.mark.usefixtures("fine")
def test_what_is_left_out_is_of_the_fourth_order(ways: list[str]) -> None:
    """In the period, with a dead time in proportion to it, of currents that keep their signs."""
    errors = []
    for T_s in (1.6e-4, 0.8e-4):
        period = Period("dead time", 3, 20.0, T_s=T_s)
        error = np.abs(period.run(edges=False) - period.run(edges=True))
        errors.append(error[:4].max())
    assert ways == ["followed", "followed"]
    assert np.log2(errors[0] / errors[1]) > 3.5


SLOPES = st.floats(-1e5, 1e5) | st.just(0.0)


@given(
    sign=st.sampled_from([1.0, -1.0]),
    start=st.floats(0.0, 10.0) | st.just(0.0),
    slope=SLOPES,
    bend=st.floats(-1e8, 1e8) | st.just(0.0),
    h=st.floats(1e-9, 1e-4),
)
@example(sign=1.0, start=0.0, slope=1.0, bend=-1e6, h=1e-4)
@example(sign=-1.0, start=0.0, slope=0.0, bend=-1e6, h=1e-4)
def test_a_current_that_ends_with_the_other_sign_comes_to_zero_before(
    sign: float, start: float, slope: float, bend: float, h: float
) -> None:
    after = start + h * (slope + h * bend)
    at = crossing(sign, sign * start, sign * slope, sign * bend, sign * after)
    if after >= 0.0:
        assert at > 1.0
        return
    assert 0.0 <= at <= h * (1.0 + 1e-9)
    scale = start + at * (abs(slope) + at * abs(bend))
    assert abs(start + at * (slope + at * bend)) <= 1e-9 * scale


def test_two_currents_at_zero_are_left_to_the_edges(ways: list[str]) -> None:
    core = make_core(motor=IDLE, inverter=DEVICES, sensors=WIDE, parameters=NO_TRIP)
    core.shaft.omega_m = 10.0
    core.command.pwm_enabled = 1
    run_period(core, np.array([0.5, 0.5, 0.5]))
    assert ways == ["edges"]
