"""Differences of successive periods without what a swing of the fundamental leaves in all orders of them."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import NDArray

Bools = NDArray[np.bool_]
Complex = NDArray[np.complex128]

_FAR, _FEWEST = 4.0, 24  # medians, of a difference that a step is in; differences
_SECOND_DIFFERENCES = np.array([1.0, -4.0, 6.0, -4.0, 1.0]) / 6.0  # correlation of those of white noise
_ROUNDS, _UNLIKE = 4, 5.0  # of the fit; median deviations of what it leaves above the median, of a step
_BESIDE = 2  # orders, whose noise is as that of the fundamental
_CLEARLY = 3.0  # times what noise makes of a course


def without_swing(differences: Complex) -> Complex | None:
    """Return second differences of the phasors of successive periods, shape (n - 2, orders - 1), of orders 2
    and up, without what goes with those of order 1; None of too few of them, shape (n, orders).

    A fundamental that swings from period to period leaves some of it in all orders, and harmonics swing with
    it: as multiples of its own differences, of those before and after, and of their conjugates, as far as
    these are no noise. Those without a step tell them. The noise that they fit is made up for.
    """
    if len(differences) < _FEWEST:
        return None
    own, others = differences[:, 0], differences[1:-1, 1:]
    swing = np.stack([own[:-2], own[1:-1], own[2:]], axis=1)
    swing = np.concatenate([swing, np.conj(swing)], axis=1)
    size = np.max(np.abs(swing), axis=1)
    is_usual = size < _FAR * float(np.median(size))
    even, courses = is_usual, swing
    for _ in range(_ROUNDS):
        left = _without(courses, others, even)
        power = np.mean(np.square(np.abs(left)), axis=1)
        above = power - np.median(power)
        even = is_usual & (above < _UNLIKE * float(np.median(np.abs(above))))
        if np.count_nonzero(even) < _FEWEST:
            return None
        noise = math.sqrt(float(np.mean(np.square(np.abs(left[even, :_BESIDE])))))
        _, sizes, directions = np.linalg.svd(swing[even], full_matrices=False)
        clear = sizes > _CLEARLY * noise * math.sqrt(np.count_nonzero(even))
        courses = swing @ np.conj(directions[clear]).T
    return _without(courses, others, even) / math.sqrt(_share_of_noise(courses, even))


def _without(courses: Complex, others: Complex, even: Bools) -> Complex:
    """Return differences, shape (n, orders), without the multiples of `courses`, shape (n, columns), that fit
    the `even` ones."""
    return np.asarray(others - courses @ np.linalg.lstsq(courses[even], others[even], rcond=None)[0])


def _share_of_noise(courses: Complex, even: Bools) -> float:
    """Return how much of the power of second differences of white noise a fit of `courses`, shape (n,
    columns), to the `even` ones leaves in these: it takes more of what changes its sign from one to the
    next."""
    basis = np.zeros_like(courses)
    basis[even] = np.linalg.qr(courses[even])[0]
    alike = [np.convolve(each, _SECOND_DIFFERENCES, "same") for each in basis.T]
    fitted = sum(float(np.vdot(each, other).real) for each, other in zip(basis.T, alike, strict=True))
    return 1.0 - fitted / int(np.count_nonzero(even))
