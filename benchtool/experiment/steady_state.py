"""All that a steady state tells: the core of every run, and what its further channels give."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass

import numpy as np

from benchtool.analysis import (
    Measurement,
    SteadyState,
    Table,
    analyze_steady_state,
)
from benchtool.analysis.flux_trajectory import flux_trajectory
from benchtool.analysis.orders import order_analysis
from benchtool.analysis.residual import NEEDED as NEEDED_TO_PREDICT
from benchtool.analysis.residual import torque_residual
from benchtool.analysis.switching import switching_states
from benchtool.block import Block
from benchtool.profile import Motor

_FEWEST_REVOLUTIONS = 2.0


@dataclass(frozen=True)
class Further:
    """What channels that not every capture has give besides."""

    measurements: tuple[Measurement, ...]
    tables: tuple[Table, ...] = ()


def assess_steady_state(
    window: Block, motor: Motor, transducer: Block | None = None
) -> tuple[SteadyState, Further]:
    """Every analysis of a steady state that the channels of a window allow, side by side in threads.

    Raises:
        AnalysisError: as the analyses: a gap, a dead signal, a speed that is not steady.
    """
    with ThreadPoolExecutor(thread_name_prefix="benchtool-analysis") as pool:
        further = [pool.submit(task) for task in _where_recorded(window, motor, transducer)]
        steady = analyze_steady_state(
            window,
            pole_pairs=motor.pole_pairs,
            torque_rated_Nm=motor.T_N_Nm,
            transducer=transducer,
            current_rated_A_rms=motor.I_N_A_rms,
        )
        found = [part.result() for part in further]
    return steady, Further(
        tuple(each for part in found for each in part.measurements),
        tuple(each for part in found for each in part.tables),
    )


def _where_recorded(window: Block, motor: Motor, transducer: Block | None) -> Iterator[Callable[[], Further]]:
    """The analyses that take channels which not every capture has."""
    names = set(window.names)
    if {"psi_alpha", "psi_beta"} <= names:
        yield lambda: Further(flux_trajectory(window))
    if {"u_alpha", "u_beta", "u_dc"} <= names:
        yield lambda: _switching(window)
    if names.issuperset(NEEDED_TO_PREDICT) and window.stride == 1:
        yield lambda: Further(torque_residual(window, motor, transducer))
    if {"theta_m", "torque"} <= names:
        yield lambda: _orders(window, motor)


def _switching(window: Block) -> Further:
    states = switching_states(window)
    return Further(states.measurements, states.tables)


def _orders(window: Block, motor: Motor) -> Further:
    if _revolutions(window) < _FEWEST_REVOLUTIONS:
        return Further(())
    orders = order_analysis(window, "torque", pole_pairs=motor.pole_pairs, slots=motor.slots)
    return Further(orders.measurements, orders.tables)


def _revolutions(window: Block) -> float:
    """Mechanical revolutions from the first row to the last."""
    theta_m = np.unwrap(window.column("theta_m"))
    return abs(float(theta_m[-1] - theta_m[0])) / (2.0 * math.pi)
