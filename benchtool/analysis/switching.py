"""Switching frequency from the drive's counter of turn-ons, and the inverter's states behind its voltages."""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Final

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.declaration import Analysis, Drawing, Findings, NoSettings, Quantity
from benchtool.analysis.measurement import Basis, Measurement, Table
from benchtool.analysis.quantisation.vector_steps import vectors_as_read
from benchtool.analysis.sensitivity import NO_SENSORS, Error, Sensitivities, Sensitivity
from benchtool.analysis.statistics.scatter import TOO_SLOW, error_of_record
from benchtool.analysis.uncertainty import Contribution, Uncertainty, combined
from benchtool.analysis.validity import (
    require_dc_link,
    require_finite,
    require_finite_channels,
    require_unbroken,
)
from benchtool.analysis.window import Window
from benchtool.block import Block
from benchtool.errors import AnalysisError
from benchtool.ticks import TICKS

_LEGS = 3
_SCATTER = "scatter over parts of the record, with their correlation"
_SQRT3 = math.sqrt(3.0)
_VECTORS = 7  # the zero vectors 0 and 7 count as one: the voltage is the same
_FEWEST_OF_A_SCATTER = 20  # samples
_USED = 1e-5  # of a period, above the rounding of single-precision voltages
_LARGEST_STEP = 0.1  # of the dc link: larger ones are the inverter's own, in laws of single vectors
_RESOLUTION = "resolution of the voltages"

# Vector 1 ... 6 lies at (k - 1) 60 degrees: 100, 110, 010, 011, 001, 101.
_ONE_LEG_HIGH = np.array([1, 3, 5])  # by the leg that is high
_ONE_LEG_LOW = np.array([4, 6, 2])  # by the leg that is low


@dataclass(frozen=True)
class SwitchingStates:
    """Result of `switching_states`; `shares` has shape (n, 7): of each period, the zero vectors first."""

    measurements: tuple[Measurement, ...]
    tables: tuple[Table, ...]
    shares: NDArray[np.float64]


def mean_switching_frequency_Hz(switching_count: NDArray[np.float64], sample_period_s: float) -> float:
    """Return the mean frequency of one switch: turn-ons of the three upper switches / (3 * duration).

    `switching_count`, shape (n,), counts the turn-ons of all three upper switches since power-up and wraps
    around as a u32; the duration is that of the n - 1 intervals between the samples.

    Raises:
        AnalysisError: fewer than two samples, one that is not finite, or the counter went backwards (the
            drive restarted).
    """
    if len(switching_count) < 2:
        raise AnalysisError(
            f"'switching_count' has {len(switching_count)} samples, at least 2 are needed: "
            f"record a longer window"
        )
    require_finite(switching_count, "switching_count")
    turn_ons = np.mod(np.diff(switching_count), TICKS)
    if not np.all(turn_ons < TICKS / 2):
        raise AnalysisError(
            "'switching_count' went backwards within the window, a counter that only grows (u32, wrapping) "
            "is expected: the drive restarted, choose a window on one side of it"
        )
    return float(np.sum(turn_ons)) / (_LEGS * len(turn_ons) * sample_period_s)


def switching_frequency(block: Block) -> Measurement:
    """`mean_switching_frequency_Hz` of a capture without gaps that has switching_count.

    Raises:
        AnalysisError: a gap, no such channel, too short, or the counter went backwards.
    """
    require_unbroken(block)
    count, rate_Hz = block.column("switching_count"), block.sample_rate_Hz
    value_Hz = mean_switching_frequency_Hz(count, 1.0 / rate_Hz)
    duration_s = (len(count) - 1) / rate_Hz
    uncertain = _of_frequency(np.mod(np.diff(count), TICKS), rate_Hz)
    return Measurement(
        "switching_frequency_mean",
        value_Hz,
        "Hz",
        "number of times that an upper switch turns on, of all three legs / (3 x duration)",
        Basis(len(count), rate_Hz, duration_s, gaps=0),
        uncertain,
        uncertainty_reason=TOO_SLOW if uncertain is None else "",
        sensitivities=NO_SENSORS,
    )


def _of_frequency(turn_ons: NDArray[np.float64], rate_Hz: float) -> Uncertainty | None:
    """Return the uncertainty of the mean frequency: the count at both ends, and irregular turn-ons; None
    where these wander over the whole record. Of fewer than 20 samples it is that of the count.

    Of each leg, up to one turn-on more or less is counted between two ends at any place of its period. The
    scatter over parts of the record has that of their ends in it, and counts beyond it.
    """
    error, per_second = error_of_record(turn_ons), rate_Hz / _LEGS
    by_count = math.sqrt(_LEGS / 6.0) / len(turn_ons)
    budget = [Contribution("a count of one of each leg either way, triangular", "B", per_second * by_count)]
    if len(turn_ons) >= _FEWEST_OF_A_SCATTER:
        beyond = math.sqrt(max(error.standard**2 - by_count**2, 0.0))  # in this order nan stays nan
        budget.append(replace(error, standard=beyond).line(_SCATTER, per_second))
    return combined(budget, "; ".join(each.name for each in budget))


def vector_shares(
    u_alpha: NDArray[np.float64], u_beta: NDArray[np.float64], u_dc: NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the share of a period that each basic vector takes to make a mean voltage, shape (n, 7), rows of
    sum 1.

    Column 0 is the zero vectors, column k vector k at (k - 1) 60 degrees and of length 2/3 u_dc: T_0, T_1 and
    T_2 of space-vector modulation over T_s. With the phase voltages in order, greatest minus middle over
    u_dc is the share with one leg high, middle minus least that with two. A voltage beyond the hexagon
    counts as the one on its edge in the same direction. All inputs have shape (n,), V peak; u_dc is above 0.
    """
    phases = np.stack(
        [u_alpha, -0.5 * u_alpha + 0.5 * _SQRT3 * u_beta, -0.5 * u_alpha - 0.5 * _SQRT3 * u_beta], axis=1
    )
    order = np.argsort(phases, axis=1)
    least, middle, greatest = np.take_along_axis(phases, order, axis=1).T / u_dc
    scale = np.maximum(1.0, greatest - least)
    rows = np.arange(len(phases))
    shares = np.zeros((len(phases), _VECTORS))
    shares[rows, _ONE_LEG_HIGH[order[:, 2]]] = (greatest - middle) / scale
    shares[rows, _ONE_LEG_LOW[order[:, 0]]] = (middle - least) / scale
    shares[:, 0] = np.maximum(0.0, 1.0 - (greatest - least))  # nothing at all beyond the hexagon
    return shares


def switching_states(block: Block) -> SwitchingStates:
    """Return how long, and in how many periods, the inverter uses each of its states to make the voltage
    asked.

    Args:
        block: a capture without gaps, with u_alpha and u_beta, the mean voltage of the period after each
            row, and u_dc, measured in that row.

    Raises:
        AnalysisError: a gap, a missing channel, or a dc link that is not above zero.
    """
    require_unbroken(block)
    u_dc = block.column("u_dc")
    require_dc_link(u_dc)
    require_finite_channels(block, ("u_alpha", "u_beta", "u_dc"))
    u_alpha, u_beta = block.column("u_alpha"), block.column("u_beta")
    shares = vector_shares(u_alpha, u_beta, u_dc)
    rate_Hz = block.sample_rate_Hz
    basis = Basis(len(shares), rate_Hz, len(shares) / rate_Hz, reference="the PWM period", gaps=0)
    numbers = _numbers(shares, basis, _errors_of_steps(u_alpha, u_beta, float(np.mean(u_dc))))
    return SwitchingStates(tuple(numbers), (_table(shares, basis),), shares)


def _errors_of_steps(
    u_alpha: NDArray[np.float64], u_beta: NDArray[np.float64], u_dc: float
) -> tuple[float, float]:
    """Return the rms error of the mean zero share, %, and of the mean number of active vectors, by the steps
    in which the voltages are read."""
    moved = []
    for drawn in vectors_as_read(u_alpha, u_beta, _LARGEST_STEP * u_dc):
        before, on_average, once = (vector_shares(u.real, u.imag, np.full(len(u), u_dc)) for u in drawn)
        of_zero = 100.0 * float(np.mean(on_average[:, 0] - before[:, 0]))
        moved.append((of_zero, float(np.mean(_active(once) - _active(before)))))
    if not moved:
        return 0.0, 0.0
    zero, active = np.sqrt(np.mean(np.square(moved), axis=0))
    return float(zero), float(active)


def _active(shares: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the number of active vectors that each period has."""
    return np.asarray(np.sum(shares[:, 1:] > _USED, axis=1), np.float64)


def _numbers(shares: NDArray[np.float64], basis: Basis, of_steps: tuple[float, float]) -> list[Measurement]:
    by_zero, by_active = ([Contribution(_RESOLUTION, "B", each)] if each else [] for each in of_steps)
    # a period with another number, or vector, may come next, though none has been seen
    one_period = 1.0 / (_SQRT3 * len(shares))
    zero = shares[:, 0]
    if np.all((zero <= _USED) | (zero >= 1.0 - _USED)):
        by_zero.append(Contribution("one period of another vector, rectangular", "B", 100.0 * one_period))
    return [
        _mean(
            100.0 * zero,
            "zero_vector_share",
            "%",
            "mean share of a PWM period without voltage, T_0 / T_s",
            basis,
            *by_zero,
        ),
        _mean(
            _active(shares),
            "active_vectors_mean",
            "",
            "mean number of active vectors in a PWM period",
            basis,
            *by_active,
            Contribution("one period of another number, rectangular", "B", one_period),
        ),
    ]


# a drive makes times of its voltages by its reading of the dc link, whatever error that has
_BY_VOLTAGES: Final = Sensitivities(
    tuple(Sensitivity(channel, again=frozenset(Error)) for channel in ("u_alpha", "u_beta"))
)


def _mean(
    samples: NDArray[np.float64], name: str, unit: str, definition: str, basis: Basis, *further: Contribution
) -> Measurement:
    budget = [error_of_record(samples).line(_SCATTER), *further]
    uncertain = combined(budget, "; ".join(each.name for each in budget))
    why = TOO_SLOW if uncertain is None else ""
    value = float(np.mean(samples))
    return Measurement(
        name, value, unit, definition, basis, uncertain, uncertainty_reason=why, sensitivities=_BY_VOLTAGES
    )


def _table(shares: NDArray[np.float64], basis: Basis) -> Table:
    share = 100.0 * np.mean(shares, axis=0)
    used = 100.0 * np.mean(shares > _USED, axis=0)
    angle = np.array([math.nan, *(60.0 * np.arange(_VECTORS - 1))])
    return Table(
        "switching_states",
        "basic vectors that make u_alpha, u_beta from u_dc by space-vector modulation, 0 standing for both "
        "zero vectors, which have no angle: share of the time, and share of the periods in which the vector "
        "is used",
        (("vector", ""), ("angle", "deg"), ("time_share", "%"), ("period_share", "%")),
        tuple((float(k), float(angle[k]), float(share[k]), float(used[k])) for k in range(_VECTORS)),
        basis,
    )


def _measure_frequency(window: Window, _: NoSettings) -> Findings:
    return Findings((switching_frequency(window.block),))


def _measure_states(window: Window, _: NoSettings) -> Findings:
    states = switching_states(window.block)
    return Findings(states.measurements, states.tables, states)


SWITCHING_FREQUENCY: Final = Analysis(
    name="switching_frequency",
    title="switching frequency",
    measure=_measure_frequency,
    quantities=(
        Quantity(
            ("switching_frequency_mean",),
            "Hz",
            "number of times that an upper switch turns on, of all three legs / (3 x duration)",
            "one count of each leg, `1 / (3 sqrt(2) duration)`, and what exceeds that of the scatter over 64 "
            "parts with their correlation, or the five lowest frequencies where these hold less than a fifth "
            "of that, or the density continued to zero frequency where that is 1.4 times as much; an "
            "oscillation by `sin(pi k) / (pi k)` of its rms, k the cycles that the record has",
        ),
    ),
    settings=NoSettings,
    channels=("switching_count",),
)
SWITCHING_STATES: Final = Analysis(
    name="switching_states",
    title="switching states",
    measure=_measure_states,
    quantities=(
        Quantity(
            ("zero_vector_share",),
            "%",
            "mean of `T_0 / T_s`",
            "scatter over 64 parts of the record with their correlation, or the five lowest frequencies "
            "where these hold less than a fifth of that, or the density continued to zero frequency where "
            "that is 1.4 times as much; an oscillation by `sin(pi k) / (pi k)` of its rms, k the cycles that "
            "the record has; resolution of the voltages, by vectors that would be read alike; of "
            "single vectors `100 / (sqrt(3) n)`, as one period of another vector may come next",
        ),
        Quantity(
            ("active_vectors_mean",),
            "",
            "mean number of active vectors in a period: 2 for space-vector modulation, at most 1 for laws of "
            "single vectors",
            "likewise, and `1 / (sqrt(3) n)`: one period of another number may come next",
        ),
    ),
    settings=NoSettings,
    channels=("u_alpha", "u_beta", "u_dc"),
    figures=(
        Drawing("switching_states", "Switching states", "Share of time of the inverter's voltage vectors."),
    ),
)
