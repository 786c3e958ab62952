"""Current sensors with a bandwidth and a delay, read by the converter at a moment within the control period.

A sensor is a lag of first order, y' = omega (i - y), behind the phase's current. Within an integration step
the current is the cubic through its values and rates at both ends, for which the lag is solved exactly. A
delay of the sensor is an earlier moment of reading: the two are one, as nothing changes in time.
"""

from __future__ import annotations

import math
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import NDArray

from benchtool.emulator.jit import njit
from benchtool.emulator.machine.coefficients import Machine
from benchtool.emulator.machine.plant import current_rates
from benchtool.emulator.machine.state import State, stationary_currents

_AXES = ((1.0, 0.0), (-0.5, 0.5 * math.sqrt(3.0)), (-0.5, -0.5 * math.sqrt(3.0)))  # of the phases
_LAGGED, _TAKEN, _BEFORE, _DONE = 0, 1, 2, 3  # rows of `values`
_SMALL = 0.25  # up to which the series is used: beyond it the other way loses three digits at most
_TERMS = tuple(1.0 / (j + 4.0) for j in range(10, 0, -1))  # of the series


class Lag(NamedTuple):
    """Corner frequencies of the sensors of phases a, b and c in rad/s; infinite without a lag."""

    omega: tuple[float, float, float]


class Sampling(NamedTuple):
    """When the currents of phases a, b and c are read.

    `moments` counts in s from the start of a control period, 0 excluded and its end included; `periods` is
    how many control periods before the one that ends with the control tick, 0 or 1. `values`, of shape
    (4, 3), has for each phase what its sensor reads now, what was read in this period and in the one before,
    and whether it was read in this one yet.
    """

    moments: tuple[float, float, float]
    periods: tuple[int, int, int]
    lag: Lag | None
    values: NDArray[np.float64]

    def begin(self, currents: tuple[float, float, float], before: Sampling | None) -> None:
        """Go on from the sampling before, or from currents that have been these for long."""
        self.values[:_DONE] = currents if before is None else before.values[:_DONE]


def sampling_of(
    T_s: float, ages: tuple[float, float, float], omega: tuple[float, float, float]
) -> Sampling | None:
    """Return the reading of currents that are this old at the control tick, by sensors of these corner
    frequencies.

    Args:
        T_s: control period in s.
        ages: of phases a, b and c in s, 0 or more and less than two periods.
        omega: in rad/s, infinite without a lag.
    """
    lagging = any(math.isfinite(each) for each in omega)
    if not lagging and not any(ages):
        return None
    a, b, c = (int(age // T_s) for age in ages)
    at_a, at_b, at_c = (T_s - age % T_s for age in ages)
    return Sampling((at_a, at_b, at_c), (a, b, c), Lag(omega) if lagging else None, np.zeros((4, 3)))


@njit
def observe(
    sampling: Sampling | None,
    time: float,
    h: float,
    before: State,
    after: State,
    u_alpha: float,
    u_beta: float,
    machine: Machine,
    T_load: float,
) -> None:
    """Have the sensors follow an integration step, and read what is due within it.

    It started `time` seconds into the control period and took `h`.
    """
    if sampling is None:
        return
    _follow(sampling.lag, sampling, time, h, before, after, u_alpha, u_beta, machine, T_load)


@njit
def _follow(
    lag: Lag | None,
    sampling: Sampling,
    time: float,
    h: float,
    before: State,
    after: State,
    u_alpha: float,
    u_beta: float,
    machine: Machine,
    T_load: float,
) -> None:
    values = sampling.values
    if lag is None and not _due(sampling.moments, time, h):
        return
    alpha0, beta0, alpha0_rate, beta0_rate = _stationary(before, u_alpha, u_beta, machine, T_load)
    alpha1, beta1, alpha1_rate, beta1_rate = _stationary(after, u_alpha, u_beta, machine, T_load)
    w = _weights_of(lag, 0, h)
    for k in range(3):
        if k > 0:
            w = _next_weights(lag, k, h, w)
        n_alpha, n_beta = _AXES[k]
        start, rise = n_alpha * alpha0 + n_beta * beta0, h * (n_alpha * alpha0_rate + n_beta * beta0_rate)
        end, fall = n_alpha * alpha1 + n_beta * beta1, h * (n_alpha * alpha1_rate + n_beta * beta1_rate)
        square = 3.0 * (end - start) - 2.0 * rise - fall
        cube = rise + fall - 2.0 * (end - start)
        y, moment = values[_LAGGED, k], sampling.moments[k]
        if time < moment <= time + h:
            s = (moment - time) / h
            till_then = _weights_of(lag, k, s * h)
            values[_TAKEN, k] = _reading(till_then, y, start, s * rise, s * s * square, s * s * s * cube)
            values[_DONE, k] = 1.0
        values[_LAGGED, k] = _reading(w, y, start, rise, square, cube)


@njit
def _due(moments: tuple[float, float, float], time: float, h: float) -> bool:
    """Return whether a current is to be read within the step."""
    at_a, at_b, at_c = moments
    until = time + h
    return time < at_a <= until or time < at_b <= until or time < at_c <= until


@njit
def _stationary(
    x: State, u_alpha: float, u_beta: float, machine: Machine, T_load: float
) -> tuple[float, float, float, float]:
    """Return alpha and beta of the current, and their rates."""
    di_d, di_q = current_rates(x, u_alpha, u_beta, machine)
    di_d, di_q = di_d - x.omega_e * x.i_q, di_q + x.omega_e * x.i_d
    i_alpha, i_beta = stationary_currents(x)
    return (
        i_alpha,
        i_beta,
        di_d * x.cos_theta - di_q * x.sin_theta,
        di_d * x.sin_theta + di_q * x.cos_theta,
    )


@njit
def _reading(
    w: tuple[float, float, float, float], y: float, c_0: float, c_1: float, c_2: float, c_3: float
) -> float:
    """Return what a sensor that read `y` reads at the end of the current c_0 + c_1 s + c_2 s^2 + c_3 s^3."""
    return y + w[0] * (c_0 - y) + w[1] * c_1 + w[2] * c_2 + w[3] * c_3


@njit
def _weights_of(lag: Lag | None, phase: int, h: float) -> tuple[float, float, float, float]:
    """Return the weights of a phase for a step of `h` seconds; without a lag only the end of it counts."""
    if lag is None:
        return 1.0, 1.0, 1.0, 1.0
    return weights(lag.omega[phase] * h)


@njit
def _next_weights(
    lag: Lag | None, phase: int, h: float, before: tuple[float, float, float, float]
) -> tuple[float, float, float, float]:
    """Return the weights of a phase, which are those of the one before where the sensors are alike."""
    if lag is None:
        return before
    return before if lag.omega[phase] == lag.omega[phase - 1] else weights(lag.omega[phase] * h)


@njit
def weights(a: float) -> tuple[float, float, float, float]:
    """Return a times the integrals of exp(-a (1 - s)) s^k over s from 0 to 1, for k = 0 to 3.

    They are what a lag of `a` radians in a step makes of a current that is s^k in it, and obey
    w_k = 1 - (k / a) w_(k-1). That is stable downwards for a small `a`, from the series of the last one, a
    times the sum of (-a)^j 3! / (j + 4)!.
    """
    if a > _SMALL:
        w_0 = 1.0 - math.exp(-a)
        w_1 = 1.0 - w_0 / a
        w_2 = 1.0 - 2.0 / a * w_1
        return w_0, w_1, w_2, 1.0 - 3.0 / a * w_2
    series = 1.0
    for each in _TERMS:
        series = 1.0 - a * each * series
    w_3 = 0.25 * a * series
    w_2 = a * (1.0 - w_3) * (1.0 / 3.0)
    w_1 = a * (1.0 - w_2) * 0.5
    return a * (1.0 - w_1), w_1, w_2, w_3


@njit
def sampled(sampling: Sampling | None, i_a: float, i_b: float, i_c: float) -> tuple[float, float, float]:
    """Return what the converter reads for a control tick at which the currents are these."""
    if sampling is None:
        return i_a, i_b, i_c
    i_a, i_b, i_c = _at_the_end(sampling.lag, sampling.values, i_a, i_b, i_c)
    return _taken(sampling, 0, i_a), _taken(sampling, 1, i_b), _taken(sampling, 2, i_c)


@njit
def _at_the_end(
    lag: Lag | None, values: NDArray[np.float64], i_a: float, i_b: float, i_c: float
) -> tuple[float, float, float]:
    if lag is None:
        return i_a, i_b, i_c
    return values[_LAGGED, 0], values[_LAGGED, 1], values[_LAGGED, 2]


@njit
def _taken(sampling: Sampling, phase: int, at_the_end: float) -> float:
    """Return the reading of a phase, and have the next period begin.

    A moment that the steps did not come to, by rounding, is the end of the period.
    """
    values: Any = sampling.values
    now = values[_TAKEN, phase] if values[_DONE, phase] != 0.0 else at_the_end
    earlier = values[_BEFORE, phase]
    values[_BEFORE, phase], values[_DONE, phase] = now, 0.0
    reading: float = earlier if sampling.periods[phase] != 0 else now
    return reading
