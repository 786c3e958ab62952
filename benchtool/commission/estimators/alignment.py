"""The encoder against the rotor flux, from a current vector that drags the rotor round in both directions.

A rotor without load lies along a standing current. Dragged slowly it lags behind it by the angle delta that
its friction takes,

    sin(delta) = T / (3/2 p psi_r i),

in the opposite sense when it is dragged the other way: the mean of both is free of it. Over whole revolutions
it is free of cogging and of an eccentric disc, too. With the counted angle theta_c, in the direction of the
encoder, and that of the current theta_i,

    p theta_c - theta_i = p (offset + error(theta_c)) - sense delta.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

from benchtool.commission.estimators.regression import Fit, least_squares
from benchtool.errors import AnalysisError

_FEWEST = 100
_LEAST_SHARE = 0.2
_JUMP = 8.0  # median changes of angle from a row to the next: of more the counter has wrapped
_HARMONICS = (1, 2)  # of the encoder's error, in a revolution
_WHOLE = 0.97  # of a revolution, from which on it tells them
_TOLD_APART = 1.5  # revolutions, from which on they are told from a slope
_SWING = 12.0 / (2.0 * math.pi * math.sqrt(2.0))  # of a line's slope by one swing, rms over its phases


@dataclass(frozen=True)
class Spin:
    """What was captured while the rotor was dragged one way.

    `theta_m_rad` is the angle that the drive counts, with an offset of zero and the direction forward;
    `current_rad` the electrical angle of the current vector against phase a, `share` its length over the
    nominal one; shapes (n,). `sense` is 1 for turning from phase a to b, -1 for the other way.
    """

    theta_m_rad: NDArray[np.float64]
    current_rad: NDArray[np.float64]
    share: NDArray[np.float64]
    sense: int


@dataclass(frozen=True)
class Motion:
    """How the counted angle goes with the current's.

    `per_rad` is the mechanical angle counted for a radian of the current's electrical one, with its standard
    uncertainty by the scatter over the spins and by the swings of the rotor; `jump_rad` the angle that the
    counter leaps where it wraps, 2 pi less what it should, 0 where it does not; `moved_rad` what was counted
    in the longest spin. `error_left`: an eccentric encoder may change `per_rad`.
    """

    per_rad: float
    per_rad_standard: float
    jump_rad: float
    moved_rad: float
    error_left: bool


@dataclass(frozen=True)
class Alignment:
    """Angles in rad; `offset_rad` is mechanical, within half an electrical revolution of zero.

    `lag_rad` is the electrical angle by which friction holds the rotor back at the nominal current.
    `errors_rad` are the complex amplitudes of the encoder's error once and twice in a revolution, the real
    part of each times exp(-j n theta_m), and `apart_rad` by how much those of both spins differ; None where
    less than a revolution was turned. All are of as many of the last revolutions as tell the offset best.
    `ripple_rad` is the rms electrical deviation over the whole of the spins.
    """

    offset_rad: float
    offset_standard_rad: float
    lag_rad: float
    lag_standard_rad: float
    errors_rad: tuple[complex, complex] | None
    error_standard_rad: float
    apart_rad: tuple[float, float] | None
    ripple_rad: float
    dof: float


def motion(spins: Sequence[Spin], swings: float) -> Motion:
    """Return how far and which way the encoder counted.

    From one and a half revolutions on, it is the slope of a line with the encoder's error beside it. Of less,
    that error is hardly told from a slope, and after a whole revolution it is what it was: the slope is that
    from end to end.

    Args:
        spins: of about equal length.
        swings: how often the rotor swings about the current in one of them.

    Raises:
        AnalysisError: too few rows, or a current that does not turn.
    """
    slopes, swung, jumps, moved, told_apart = [], [], [0.0], 0.0, True
    for spin in spins:
        if len(spin.theta_m_rad) < _FEWEST:
            raise AnalysisError(f"{len(spin.theta_m_rad)} rows of a turning current, {_FEWEST} are needed")
        counted, jump = continued(spin.theta_m_rad)
        jumps.append(jump)
        turned = np.unwrap(spin.current_rad)
        line = np.column_stack([turned, np.ones(len(turned))])
        if np.ptp(counted) >= _WHOLE * 2.0 * math.pi:
            line = np.column_stack([line, *_of_revolution(counted)])
        fit = least_squares(line, counted)
        apart = np.ptp(counted) >= _TOLD_APART * 2.0 * math.pi
        by = _SWING / max(swings, _SWING) if apart else 1.0
        slopes.append(float(fit.x[0] if apart else (counted[-1] - counted[0]) / (turned[-1] - turned[0])))
        swung.append(by * math.sqrt(2.0) * fit.scatter / float(np.ptp(turned)))
        told_apart &= bool(apart)
        moved = max(moved, float(abs(counted[-1] - counted[0])))
    largest = max(jumps, key=abs)
    standard = max(float(np.ptp(slopes)), math.sqrt(float(np.mean(np.square(swung)))))
    return Motion(float(np.mean(slopes)), standard, largest, moved, not told_apart)


def continued(theta_rad: NDArray[np.float64]) -> tuple[NDArray[np.float64], float]:
    """Return an angle without its wraps, shape (n,), and by how much these leap besides 2 pi.

    A counter that wraps after another number of counts than the drive believes leaps.
    """
    steps = np.diff(np.unwrap(theta_rad))
    typical = float(np.median(np.abs(steps)))
    count = float(np.min(np.abs(steps[steps != 0.0]), initial=math.inf))
    leaps = np.abs(steps - np.median(steps)) > _JUMP * max(typical, count if math.isfinite(count) else 0.0)
    leap = float(steps[leaps][np.argmax(np.abs(steps[leaps]))]) if np.any(leaps) else 0.0
    steps[leaps] = np.median(steps)
    return np.concatenate(([theta_rad[0]], theta_rad[0] + np.cumsum(steps))), leap


def alignment(spins: Sequence[Spin], pole_pairs: int, direction: int) -> Alignment:
    """Return where the encoder's zero is.

    Args:
        spins: both senses, over the same angles.
        pole_pairs: of the motor.
        direction: 1 where the encoder counts up while the rotor turns from phase a to b, else -1.

    Raises:
        AnalysisError: not both senses, or too little motion.
    """
    if {spin.sense for spin in spins} != {-1, 1}:
        raise AnalysisError("a current that turns both ways is needed to tell friction from the offset")
    first = _errors_of(spins[0], pole_pairs, direction, 0.0)[1]
    around = float(np.angle(np.mean(np.exp(1j * first))))
    theta, errors, senses = [], [], []
    for spin in spins:
        angle, error = _errors_of(spin, pole_pairs, direction, around)
        theta.append(angle - around / pole_pairs)
        errors.append(error)
        senses.append(spin.sense / np.maximum(spin.share, _LEAST_SHARE))
    turns = min(float(np.ptp(each)) for each in theta) / (2.0 * math.pi)
    whole = turns >= _WHOLE
    every = _fitted(theta, errors, senses, whole, math.inf)
    fit, last = min(
        (
            (every, math.inf),
            *((_fitted(theta, errors, senses, whole, n), n) for n in range(1, math.floor(turns) + 1)),
        ),
        key=lambda each: each[0].standard(0),
    )
    offset = (around + fit.x[0]) / pole_pairs
    period = 2.0 * math.pi / pole_pairs
    whole_periods = period * math.floor(offset / period + 0.5)
    offset -= whole_periods  # and theta_m is so much more
    found = apart = None
    if whole:
        once, twice = _amplitudes(fit.x[2:] / pole_pairs)
        turned = np.exp(1j * whole_periods)
        found = (complex(once * turned), complex(twice * turned**2))
        (on_1, on_2), (back_1, back_2) = (
            _errors_alone(*each, last, pole_pairs) for each in zip(theta, errors, strict=True)
        )
        apart = (abs(on_1 - back_1), abs(on_2 - back_2))
    return Alignment(
        offset,
        fit.standard(0) / pole_pairs,
        float(fit.x[1]),
        fit.standard(1),
        found,
        math.sqrt(2.0 / len(fit.residuals)) * fit.scatter / pole_pairs,
        apart,
        every.scatter,
        fit.dof,
    )


def _fitted(
    theta: Sequence[NDArray[np.float64]],
    errors: Sequence[NDArray[np.float64]],
    senses: Sequence[NDArray[np.float64]],
    whole: bool,
    last: float,
) -> Fit:
    """Return the fit to the last revolutions of each spin.

    A rotor that is dragged off may swing by a hundred degrees at first, of which the mean is not where it
    would rest.
    """
    rows = [_last(each, last) for each in theta]
    x, y, sense = (
        np.concatenate([each[of] for each, of in zip(parts, rows, strict=True)])
        for parts in (theta, errors, senses)
    )
    columns = [np.ones(len(x)), -sense]
    if whole:
        columns += _of_revolution(x)
    return least_squares(np.column_stack(columns), y)


def _errors_alone(
    theta: NDArray[np.float64], errors: NDArray[np.float64], last: float, pole_pairs: int
) -> tuple[complex, complex]:
    """Return the amplitudes of the encoder's error by the last revolutions of one spin.

    A rotor that swings once or twice in a revolution looks like an eccentric encoder, but not the same both
    ways.
    """
    rows = _last(theta, last)
    columns = np.column_stack([np.ones(int(np.count_nonzero(rows))), *_of_revolution(theta[rows])])
    return _amplitudes(least_squares(columns, errors[rows]).x[1:] / pole_pairs)


def _last(theta: NDArray[np.float64], revolutions: float) -> NDArray[np.bool_]:
    """Return which rows are of the last revolutions."""
    return np.asarray(np.abs(theta - theta[-1]) <= 2.0 * math.pi * revolutions)


def _amplitudes(waves: NDArray[np.float64]) -> tuple[complex, complex]:
    """Return the complex amplitudes once and twice in a revolution by those of `_of_revolution`."""
    return complex(waves[0], waves[1]), complex(waves[2], waves[3])


def _of_revolution(theta_rad: NDArray[np.float64]) -> list[NDArray[np.float64]]:
    return [wave(n * theta_rad) for n in _HARMONICS for wave in (np.cos, np.sin)]


def _errors_of(
    spin: Spin, pole_pairs: int, direction: int, around: float
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    """Return the counted angle in the encoder's direction, rad mechanical, and p theta_c - theta_i less
    `around`, within half a revolution at its beginning."""
    counted = direction * continued(spin.theta_m_rad)[0]
    error = pole_pairs * counted - np.unwrap(spin.current_rad) - around
    return counted, error - 2.0 * math.pi * math.floor(float(np.median(error)) / (2.0 * math.pi) + 0.5)
