"""The machine under prescribed switching, against another integrator of the equations in alpha/beta."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

from benchtool.emulator import open_loop
from benchtool.errors import ValueRefused

MACHINE: dict[str, Any] = {
    "resistance_ohm": 0.123,
    "inductance_H": 9.52e-3,
    "pole_pairs": 4,
    "flux_Wb": 0.1685,
    "inertia_kgm2": 13.1e-4,
    "friction_Nms": 2e-4,
    "load_torque_Nm": 0.65,
    "dc_link_V": 122.5,
}
STATES = [[0, 0, 0], [1, 0, 0], [1, 1, 0], [0, 1, 0], [0, 1, 1], [0, 0, 1], [1, 0, 1], [1, 1, 1]]


def switching(rng: np.random.Generator, lengths_s: NDArray[np.float64]) -> dict[str, Any]:
    """Random states of given lengths, with samples inside, at the edges, at the start and at the end."""
    edges = np.concatenate([[0.0], np.cumsum(lengths_s)])
    samples = np.concatenate([rng.uniform(0.0, edges[-1], 40), edges[:5], edges[-1:]])
    states = np.array(STATES)[rng.integers(0, 8, len(lengths_s))]
    return {
        "edge_times_s": edges[:-1],
        "switch_states": states,
        "end_time_s": edges[-1],
        "sample_times_s": samples,
    }


def reference(**given: Any) -> NDArray[np.float64]:
    """Rows i_alpha, i_beta, omega_m, theta_e at the samples, by scipy between the edges."""
    R, L, p, psi = (given[key] for key in ("resistance_ohm", "inductance_H", "pole_pairs", "flux_Wb"))
    J, B, T_load = (given[key] for key in ("inertia_kgm2", "friction_Nms", "load_torque_Nm"))
    legs_to_voltage = given["dc_link_V"] * np.array([[2, -1, -1], [0, math.sqrt(3), -math.sqrt(3)]]) / 3
    samples = np.asarray(given["sample_times_s"])
    edges = [*given["edge_times_s"], given["end_time_s"]]
    y = np.array([*given.get("current0_A", (0, 0)), given.get("speed0_rad_s", 0), given.get("angle0_rad", 0)])
    result = np.empty((4, len(samples)))
    for start, end, state in zip(edges, edges[1:], given["switch_states"], strict=False):
        u = legs_to_voltage @ np.asarray(state)

        def rates(_: float, y: NDArray[np.float64], u: NDArray[np.float64] = u) -> list[float]:
            i_alpha, i_beta, omega_m, theta_e = y
            c, s = math.cos(theta_e), math.sin(theta_e)
            e = p * omega_m * psi
            torque = 1.5 * p * psi * (c * i_beta - s * i_alpha)
            acceleration = 0.0 if given.get("held_speed") else (torque - B * omega_m - T_load) / J
            di_alpha = (u[0] - R * i_alpha + e * s) / L
            di_beta = (u[1] - R * i_beta - e * c) / L
            return [di_alpha, di_beta, acceleration, p * omega_m]

        inside = (samples >= start) & (samples <= end)
        if end > start:
            way = solve_ivp(
                rates, (start, end), y, "DOP853", rtol=3e-14, atol=1e-14, dense_output=True, max_step=0.02
            )
            assert way.sol is not None
            if inside.any():
                result[:, inside] = way.sol(samples[inside])
            y = way.y[:, -1]
    return result


def assert_agrees(**given: Any) -> None:
    expected = reference(**given)
    result = open_loop(**given)
    assert np.abs(result.i_alpha_A - expected[0]).max() < 1e-6
    assert np.abs(result.i_beta_A - expected[1]).max() < 1e-6
    assert np.abs(result.omega_m_rad_s - expected[2]).max() < 1e-6
    assert np.abs(result.theta_e_rad - expected[3]).max() < 1e-8


@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("current0_A", [(0.0, 0.0), (20.7, 0.0), (-14.0, 15.2)])
def test_agrees_over_ten_pwm_periods(held: bool, current0_A: tuple[float, float]) -> None:
    given = switching(np.random.default_rng(1), np.random.default_rng(2).uniform(1e-7, 3e-5, 70))
    assert_agrees(
        **MACHINE, **given, held_speed=held, current0_A=current0_A, speed0_rad_s=15.71, angle0_rad=0.7
    )


@pytest.mark.parametrize("held", [False, True])
@pytest.mark.parametrize("speed0_rad_s", [-600.0, 157.1, 600.0])
def test_agrees_at_speed(held: bool, speed0_rad_s: float) -> None:
    given = switching(np.random.default_rng(3), np.full(20, 5e-4))
    assert_agrees(**MACHINE, **given, held_speed=held, speed0_rad_s=speed0_rad_s, current0_A=(20.7, 3.0))


@pytest.mark.parametrize(
    ("change", "start"),
    [
        ({"inertia_kgm2": 2e-6, "flux_Wb": 0.3, "inductance_H": 5e-4, "resistance_ohm": 0.4}, {}),
        ({"inductance_H": 1e-5, "resistance_ohm": 1.0, "inertia_kgm2": 1e-3}, {"speed0_rad_s": 300.0}),
        ({"friction_Nms": 0.05, "inertia_kgm2": 1e-5}, {"speed0_rad_s": -200.0}),
        ({"flux_Wb": 0.0, "load_torque_Nm": -0.2}, {"current0_A": (5.0, -20.0)}),
        ({"resistance_ohm": 0.0, "pole_pairs": 10}, {"speed0_rad_s": 100.0}),
    ],
    ids=["tightly coupled", "tiny L/R", "stiff friction", "no magnet", "no resistance"],
)
def test_agrees_on_hard_machines(change: dict[str, float], start: dict[str, Any]) -> None:
    given = switching(np.random.default_rng(4), np.full(12, 1e-3))
    assert_agrees(**{**MACHINE, **change}, **given, **start)


@pytest.mark.parametrize("held", [False, True])
def test_agrees_over_segments_of_half_a_second(held: bool) -> None:
    given = switching(np.random.default_rng(5), np.array([0.5, 0.5]))
    given["switch_states"] = [[0, 0, 0], [1, 1, 1]]
    assert_agrees(**MACHINE, **given, held_speed=held, speed0_rad_s=60.0, current0_A=(20.7, 0.0))


def test_current_at_standstill_is_the_closed_form() -> None:
    times = np.linspace(0.0, 0.2, 21)
    result = open_loop(
        **{**MACHINE, "flux_Wb": 0.0},
        edge_times_s=[0.0, 0.1],
        switch_states=[[1, 0, 0], [0, 0, 0]],
        end_time_s=0.2,
        sample_times_s=times,
        held_speed=True,
    )
    tau = MACHINE["inductance_H"] / MACHINE["resistance_ohm"]
    final = 2.0 / 3.0 * 122.5 / 0.123
    risen = final * (1.0 - math.exp(-0.1 / tau))
    expected = np.where(
        times <= 0.1, final * (1.0 - np.exp(-times / tau)), risen * np.exp(-(times - 0.1) / tau)
    )
    assert np.abs(result.i_alpha_A - expected).max() < 1e-6
    assert np.abs(result.i_beta_A).max() < 1e-12


def test_held_angle_is_not_wrapped() -> None:
    result = open_loop(
        **MACHINE,
        edge_times_s=[0.0],
        switch_states=[[0, 0, 0]],
        end_time_s=1.0,
        sample_times_s=[1.0, 0.0],
        speed0_rad_s=100.0,
        angle0_rad=0.25,
        held_speed=True,
    )
    assert result.theta_e_rad == pytest.approx([400.25, 0.25], abs=1e-9)
    assert result.omega_m_rad_s == pytest.approx([100.0, 100.0])


@pytest.mark.parametrize(
    ("change", "named"),
    [
        ({"resistance_ohm": -1.0}, "R_s_ohm"),
        ({"inductance_H": 0.0}, "L_d_H"),
        ({"inertia_kgm2": float("nan")}, "J_kgm2"),
        ({"dc_link_V": -5.0}, "dc_link_V"),
        ({"current0_A": (float("inf"), 0.0)}, "i_alpha0_A"),
        ({"edge_times_s": [0.0, 0.0]}, "edge_times_s"),
        ({"edge_times_s": []}, "edge_times_s"),
        ({"edge_times_s": ["soon", "later"]}, "edge_times_s"),
        ({"switch_states": [[0, 0, 0]]}, "switch_states"),
        ({"switch_states": [[0, 0, 0], [2, 0, 0]]}, "switch_states"),
        ({"sample_times_s": [0.3]}, "sample_times_s"),
        ({"sample_times_s": [-0.1]}, "sample_times_s"),
        ({"end_time_s": 0.05}, "end_time_s"),
    ],
)
def test_refuses_in_one_line(change: dict[str, Any], named: str) -> None:
    given: dict[str, Any] = {
        **MACHINE,
        "edge_times_s": [0.0, 0.1],
        "switch_states": [[0, 0, 0], [1, 0, 0]],
        "end_time_s": 0.2,
        "sample_times_s": [0.2],
    }
    with pytest.raises(ValueRefused, match=named) as refused:
        open_loop(**{**given, **change})
    assert "\n" not in str(refused.value)
