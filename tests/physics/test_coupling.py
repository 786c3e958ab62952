"""Two masses and an elastic coupling: closed forms without play, scipy with modes of its own with it."""

from __future__ import annotations

import cmath
import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings, strategies as st
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from benchtool.emulator.machine.bounds import machine_of_bench, require_computable
from benchtool.emulator.machine.coefficients import Machine, driven_by, holding
from benchtool.emulator.machine.drive_train import Far
from benchtool.emulator.machine.state import State, facing, place
from benchtool.emulator.machine.steps import advance
from benchtool.emulator.machine.train_truth import ShaftTruth, TrainTruth
from benchtool.emulator.machine.truth import MotorTruth
from benchtool.errors import ValueRefused

P, J, J_LOAD, C, D = 4, 2e-4, 5e-4, 80.0, 0.01
ELECTRICAL: dict[str, Any] = {"pole_pairs": P, "R_s_ohm": 0.5, "L_d_H": 2e-3, "L_q_H": 2e-3, "psi_r_Wb": 0.05}
SMOOTH = MotorTruth(**ELECTRICAL, J_kgm2=J)
RUBBING = MotorTruth(**ELECTRICAL, J_kgm2=J, coulomb_Nm=0.03, breakaway_Nm=0.05, stribeck_rad_s=2.0)


def coasting(motor: MotorTruth, damping: float = D, play: float = 0.0) -> Machine:
    """The machine with open terminals on its load."""
    shaft = ShaftTruth(J_load_kgm2=J_LOAD, coupling_Nm_rad=C, coupling_Nms=damping, backlash_rad=play)
    return holding(machine_of_bench(motor, TrainTruth(shaft=shaft)), False, True)


def at(omega_m: float, omega_load: float, twist: float) -> State:
    return facing(place(0.0, 0.0, P * omega_m, 0.0), Far(omega_load, twist, 0.0))


def after(x: State, machine: Machine, duration: float, T_load: float = 0.0, turn: float = 0.01) -> State:
    return advance(x, 0.0, 0.0, duration, turn, machine, T_load)


def swinging(twist: float, per_J: float, damping: float, time: float) -> float:
    """The twist of a coupling let go, on 1 / J of what swings: x'' + d per_J x' + c per_J x = 0."""
    s = -0.5 * damping * per_J + cmath.sqrt((0.5 * damping * per_J) ** 2 - C * per_J)
    other = -damping * per_J - s
    shape: complex = (s * cmath.exp(other * time) - other * cmath.exp(s * time)) / (s - other)
    return twist * shape.real


@pytest.mark.parametrize("damping", [0.0, D, 0.5], ids=["undamped", "damped", "creeping"])
def test_resonance_and_antiresonance_are_those_of_two_masses(damping: float) -> None:
    """Free, both masses swing against each other; the load alone where the rotor is held, which is the
    antiresonance, and the rotor alone where the load is."""
    free = coasting(SMOOTH, damping)
    ends = [
        (free, 1.0 / J + 1.0 / J_LOAD),
        (holding(free, True, True), 1.0 / J_LOAD),
        (holding(driven_by(free, True, 0.0), False, True), 1.0 / J),
    ]
    for machine, per_J in ends:
        for time in (0.3e-3, 2e-3, 11e-3):
            x = after(at(0.0, 0.0, 0.02), machine, time)
            assert x.far.twist == pytest.approx(swinging(0.02, per_J, damping, time), abs=2e-8)


def test_momentum_is_kept_between_the_masses() -> None:
    x = after(at(30.0, -10.0, 0.05), coasting(SMOOTH, play=0.02), 3e-3)
    assert J * x.omega_e / P + J_LOAD * x.far.omega == pytest.approx(J * 30.0 - J_LOAD * 10.0, abs=1e-12)


def with_play(
    omega_m: float, omega_load: float, twist: float, T_load: float, play: float, duration: float
) -> NDArray[np.float64]:
    """Speeds, twist and angle of the rotor, by modes: which faces touch, and how the rotor slides."""
    m, half = RUBBING, 0.5 * play

    def pushes(y: NDArray[np.float64], side: float) -> float:
        return float(C * (side * y[2] - half) + D * side * (y[0] - y[1]))

    def rubbing(omega: float, sign: float) -> float:
        excess = (m.breakaway_Nm - m.coulomb_Nm) * math.exp(-((omega / m.stribeck_rad_s) ** 2))
        return sign * (m.coulomb_Nm + excess)

    def rates(_: float, y: NDArray[np.float64], side: float, sign: float) -> list[float]:
        torque = side * pushes(y, side) if side else 0.0
        rotor = 0.0 if sign == 0.0 else (-torque - rubbing(y[0], sign)) / m.J_kgm2
        return [rotor, (torque - T_load) / J_LOAD, y[0] - y[1], y[0]]

    def mode(y: NDArray[np.float64]) -> tuple[float, float]:
        side = math.copysign(1.0, y[2])
        gap = half - side * y[2]
        if gap > 1e-12 or pushes(y, side) < 0.0 or (gap > -1e-12 and side * (y[0] - y[1]) <= 0.0):
            side = 0.0
        torque = side * pushes(y, side) if side else 0.0
        if y[0] == 0.0 and abs(torque) <= m.breakaway_Nm:
            return side, 0.0
        return side, math.copysign(1.0, y[0] if y[0] != 0.0 else -torque)

    def rest(_: float, y: NDArray[np.float64], side: float, sign: float) -> float:
        return float(y[0]) + sign * 1e-13 if sign else 1.0

    def slips(_: float, y: NDArray[np.float64], side: float, sign: float) -> float:
        if sign:
            return 1.0
        return m.breakaway_Nm - abs(side * pushes(y, side) if side else 0.0) + 1e-9

    def parts(_: float, y: NDArray[np.float64], side: float, sign: float) -> float:
        return pushes(y, side) + 1e-9 if side else 1.0

    def meets(_: float, y: NDArray[np.float64], side: float, sign: float) -> float:
        return 1.0 if side else half - abs(y[2])

    def returns(_: float, y: NDArray[np.float64], side: float, sign: float) -> float:
        return -1.0 if side or abs(y[2]) < half else pushes(y, math.copysign(1.0, y[2]))

    events = [rest, slips, parts, meets, returns]
    for each in events:
        each.terminal = True  # type: ignore[attr-defined]
    meets.direction = -1.0  # type: ignore[attr-defined]
    returns.direction = 1.0  # type: ignore[attr-defined]
    time, y = 0.0, np.array([omega_m, omega_load, twist, 0.0])
    while time < duration:
        way = solve_ivp(  # type: ignore[call-overload]
            rates,
            (time, duration),
            y,
            "DOP853",
            events=events,
            args=mode(y),
            max_step=5e-5,  # an event that is undone within a step is missed
            rtol=1e-11,
            atol=1e-13,
        )
        time, y = way.t[-1], way.y[:, -1]
        if way.status == 1 and len(way.t_events[0]):
            y[0] = 0.0
    return y


@pytest.mark.parametrize(
    ("omega_m", "omega_load", "twist", "T_load", "play"),
    [
        (20.0, 0.0, 0.0, 0.0, 0.04),
        (0.0, 0.0, 0.0, 0.04, 0.04),
        (0.0, 0.0, 0.0, 2.0, 0.04),
        (-15.0, 10.0, 0.05, -0.2, 0.06),
        (3.0, 3.0, 0.01, 0.1, 1e-4),
        (5.0, 0.0, 0.0, 0.0, 1e3),
    ],
    ids=["runs against", "load falls and rests", "breaks away", "rebounds", "hardly any play", "never meets"],
)
@pytest.mark.parametrize("duration", [4e-3, 0.012])
def test_play_and_friction_agree_with_scipy(
    omega_m: float, omega_load: float, twist: float, T_load: float, play: float, duration: float
) -> None:
    x = after(at(omega_m, omega_load, twist), coasting(RUBBING, play=play), duration, T_load, 0.005)
    expected = with_play(omega_m, omega_load, twist, T_load, play, duration)
    seen = (x.omega_e / P, x.far.omega, x.far.twist, x.theta_e / P)
    assert seen == pytest.approx(expected, abs=2e-5)


@settings(max_examples=40, deadline=None)
@given(
    omega_m=st.floats(-50.0, 50.0),
    twist=st.floats(-0.1, 0.1),
    damping=st.sampled_from([0.0, 0.02]),
    play=st.sampled_from([1e-9, 0.01, 0.1, 1e6]),
)
def test_a_coupling_never_makes_energy(omega_m: float, twist: float, damping: float, play: float) -> None:
    def energy(x: State) -> float:
        spring = max(abs(x.far.twist) - 0.5 * play, 0.0)
        kinetic = 0.5 * J * (x.omega_e / P) ** 2 + 0.5 * J_LOAD * x.far.omega**2
        return kinetic + 0.5 * C * spring**2

    machine, x = coasting(SMOOTH, damping, play), at(omega_m, 0.0, twist)
    before = energy(x)
    y = after(x, machine, 5e-3, turn=0.05)
    assert energy(y) <= before * (1.0 + 1e-4) + 1e-12
    if damping == 0.0:
        assert energy(y) == pytest.approx(before, rel=1e-4)


@pytest.mark.parametrize(
    ("shaft", "named"),
    [
        ({"coupling_Nm_rad": 1e6, "J_load_kgm2": 1e-8}, "shaft.coupling_Nm_rad"),
        ({"coupling_Nm_rad": 1.0, "coupling_Nms": 1e3, "J_load_kgm2": 1e-4}, "shaft.coupling_Nms"),
        ({"coupling_Nm_rad": 1.0}, "shaft.J_load_kgm2"),
        ({"backlash_rad": 1.0}, "shaft.coupling_Nm_rad"),
        ({"unbalance_kgm": 1e9}, "shaft.unbalance_kgm"),
    ],
)
def test_a_shaft_that_cannot_be_computed_is_refused_by_its_keys(shaft: dict[str, float], named: str) -> None:
    with pytest.raises(ValueRefused, match=named):
        require_computable(SMOOTH, 1e-4, TrainTruth(shaft=ShaftTruth(**shaft)))
