"""The machine under a prescribed sequence of switch states, without sensors or control."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy.typing import ArrayLike, NDArray

from benchtool.emulator.in_place import in_place
from benchtool.emulator.jit import entry
from benchtool.emulator.machine.coefficients import Machine
from benchtool.emulator.machine.inverter import clarke
from benchtool.emulator.machine.state import place, stationary_currents
from benchtool.emulator.machine.steps import advance
from benchtool.emulator.machine.truth import MotorTruth, finite, not_negative, positive
from benchtool.errors import ValueRefused

_TURN = 0.002  # rad of the fastest process in one step


@dataclass(frozen=True)
class OpenLoop:
    """The machine's state at the sample times, arrays of shape (n,)."""

    i_alpha_A: NDArray[np.float64]
    i_beta_A: NDArray[np.float64]
    omega_m_rad_s: NDArray[np.float64]
    theta_e_rad: NDArray[np.float64]


def open_loop(
    *,
    resistance_ohm: float,
    inductance_H: float,
    pole_pairs: int,
    flux_Wb: float,
    inertia_kgm2: float,
    friction_Nms: float,
    load_torque_Nm: float,
    dc_link_V: float,
    edge_times_s: ArrayLike,
    switch_states: ArrayLike,
    end_time_s: float,
    sample_times_s: ArrayLike,
    current0_A: tuple[float, float] = (0.0, 0.0),
    speed0_rad_s: float = 0.0,
    angle0_rad: float = 0.0,
    held_speed: bool = False,
) -> OpenLoop:
    """Integrate a surface-magnet machine on an ideal two-level inverter, with the step of the closed loop.

    Amplitude-invariant vectors; the rotor flux is along phase a at theta_e = 0, and
    J d omega_m/dt = T - friction omega_m - load_torque.

    Args:
        edge_times_s: shape (n,), rising; the first is the start of the simulation.
        switch_states: shape (n, 3) of 0 and 1; row k says which upper switches of legs a, b, c are on from
            `edge_times_s[k]`, the last row until `end_time_s`.
        sample_times_s: shape (m,), in any order, between the first edge and the end, both included.
        current0_A: current along alpha and beta at the start.
        speed0_rad_s: mechanical speed at the start, or for good with `held_speed`.
        angle0_rad: electrical angle at the start; theta_e goes on from it and is never wrapped.

    Raises:
        ValueRefused: a number, a shape or an order that cannot be; what was seen and expected is named.
    """
    positive(dc_link_V=dc_link_V)
    finite(
        load_torque_Nm=load_torque_Nm,
        speed0_rad_s=speed0_rad_s,
        angle0_rad=angle0_rad,
        end_time_s=end_time_s,
        i_alpha0_A=current0_A[0],
        i_beta0_A=current0_A[1],
    )
    not_negative(friction_Nms=friction_Nms)
    motor = MotorTruth(
        pole_pairs=pole_pairs,
        R_s_ohm=resistance_ohm,
        L_d_H=inductance_H,
        L_q_H=inductance_H,
        psi_r_Wb=flux_Wb,
        J_kgm2=inertia_kgm2,
        friction_Nms=friction_Nms,
    )
    edges = _numbers("edge_times_s", edge_times_s)
    samples = _numbers("sample_times_s", sample_times_s)
    states = _switch_states(switch_states, len(edges))
    _refuse_times(edges, samples, end_time_s)
    order = np.argsort(samples, kind="stable")
    taken = np.empty((len(samples), 4))
    run_open_loop(
        taken,
        motor.machine(held_speed),
        edges,
        states * float(dc_link_V),
        float(end_time_s),
        samples[order],
        float(current0_A[0]),
        float(current0_A[1]),
        float(speed0_rad_s) * pole_pairs,
        float(angle0_rad),
        float(load_torque_Nm),
    )
    result = np.empty_like(taken)
    result[order] = taken
    i_alpha, i_beta, omega_m, theta_e = result.T.copy()
    return OpenLoop(i_alpha, i_beta, omega_m, theta_e)


@entry
def run_open_loop(
    result: NDArray[np.float64],
    machine: Machine,
    edges: NDArray[np.float64],
    leg_voltages: NDArray[np.float64],
    end: float,
    samples: NDArray[np.float64],
    i_alpha: float,
    i_beta: float,
    omega_e: float,
    theta_e: float,
    T_load: float,
) -> None:
    """Fill `result` with the rows (i_alpha, i_beta, omega_m, theta_e) at rising sample times."""
    machine = in_place(machine)
    c, s = math.cos(theta_e), math.sin(theta_e)
    x = place(i_alpha * c + i_beta * s, i_beta * c - i_alpha * s, omega_e, theta_e)
    time, taken = edges[0], 0
    for k in range(edges.size):
        until = edges[k + 1] if k + 1 < edges.size else end
        u_alpha, u_beta = clarke(leg_voltages[k, 0], leg_voltages[k, 1], leg_voltages[k, 2])
        while time < until or (k + 1 == edges.size and taken < samples.size):
            stop = until
            if taken < samples.size:
                stop = min(until, samples[taken])
            x = advance(x, u_alpha, u_beta, stop - time, _TURN, machine, T_load)
            x = place(x.i_d, x.i_q, x.omega_e, x.theta_e)
            time = stop
            while taken < samples.size and samples[taken] <= time:
                result[taken, 0], result[taken, 1] = stationary_currents(x)
                result[taken, 2] = x.omega_e / machine.p
                result[taken, 3] = x.theta_e
                taken += 1


def _numbers(name: str, values: ArrayLike) -> NDArray[np.float64]:
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueRefused(f"{name} holds something that is no number: give a list of numbers") from None
    if array.ndim != 1 or not len(array) or not np.isfinite(array).all():
        raise ValueRefused(f"{name} of shape {array.shape}: give at least one time, all finite, shape (n,)")
    return array


def _switch_states(values: ArrayLike, rows: int) -> NDArray[np.float64]:
    try:
        array = np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise ValueRefused("switch_states holds something that is no number: give 0 or 1") from None
    if array.shape != (rows, 3) or not np.isin(array, (0.0, 1.0)).all():
        raise ValueRefused(
            f"switch_states of shape {array.shape} for {rows} edges: give shape ({rows}, 3) of 0 and 1"
        )
    return array


def _refuse_times(edges: NDArray[np.float64], samples: NDArray[np.float64], end_time_s: float) -> None:
    if (np.diff(edges) <= 0.0).any():
        raise ValueRefused("edge_times_s does not rise throughout: sort the edges and drop repeated ones")
    if end_time_s < edges[-1]:
        raise ValueRefused(f"end_time_s = {end_time_s} is before the last edge at {edges[-1]} s: end later")
    if samples.min() < edges[0] or samples.max() > end_time_s:
        raise ValueRefused(
            f"sample_times_s reach from {samples.min()} to {samples.max()} s, the simulation from "
            f"{edges[0]} to {end_time_s} s: sample within it"
        )
