"""Response of one DFT to another where both are smooth over neighbouring bins: the local polynomial method.

Over a few bins around f, Y = H X + T, with the response H a parabola of frequency and T, what the two ends of
the record leave in (the output still moving at its start, cut off at its end), a line or a parabola. Least
squares separate them, and the residual is the noise (Pintelon and Schoukens, System Identification: A
Frequency Domain Approach, 2nd ed., 7.2). Where a resonance is sharper than a parabola follows, and that
shows, the response is a parabola over a line, which has a pole, or over another parabola, which has the two
of a lag of second order (local rational method: McKelvey and Guérin, IFAC Proc. 45 (2012) no. 16).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

REACH = 8  # bins to either side
_CURVED = 3  # terms of a parabola
_ENDS = 2  # terms of a line, for what the ends of a record leave in
_SHARP = 3.0  # times the variance that another pole leaves: one less does not follow
_BEYOND_CHANCE = 4.0  # times the mean square by which a second pole moves a response, by noise
_NEIGHBOURS = 9  # fits whose input's response counts as even
_SINGULAR = 1e-10  # smallest over largest of a triangular matrix's diagonal
_BATCH = 1024  # bins at a time: their matrices stay in the cache

Complex = NDArray[np.complex128]
Floats = NDArray[np.float64]


@dataclass(frozen=True)
class LocalFit:
    """At every `at`, all of shape (m,): response, its standard uncertainty relative to it, mean input power.

    The uncertainty is of one component, along the response or across it.
    """

    response: Complex
    error: Floats
    power: Floats


def telling(x: Complex, at: NDArray[np.int64]) -> Floats:
    """Return the share of the input's power about bins `at` that is no part of T, shape (m,): where a sweep
    begins and ends it is next to nothing."""
    shares = []
    for start in range(0, len(at), _BATCH):
        near = _near(x, at[start : start + _BATCH])
        with_ends, without = (_solve(near, near, ends, poles=0).spread for ends in (_ENDS, 0))
        shares.append(np.minimum(without / np.maximum(with_ends, np.finfo(np.float64).tiny), 1.0))
    return np.concatenate(shares)


@dataclass(frozen=True)
class IndirectFit(LocalFit):
    """A fit by a stimulus, whose power it has; `noise` is the complex variance of the input's response to
    the stimulus relative to its square, shape (m,)."""

    noise: Floats


def local_fit(x: Complex, y: Complex, at: NDArray[np.int64], *, at_rest: bool) -> LocalFit:
    """Fit the response of bins `y` to bins `x`, shape (bins,), around bins `at`, each `REACH` from the ends.

    A record that begins and ends `at_rest` has no T. Otherwise what a parabola in place of a line for T
    changes is taken as an error of its own: where a sweep begins and ends, H X looks like T.
    """
    parts = [_fit(x, y, at[start : start + _BATCH], at_rest) for start in range(0, len(at), _BATCH)]
    response, error, power = (np.concatenate(each) for each in zip(*parts, strict=True))
    return LocalFit(response, error, power)


def degrees_of_freedom(*, at_rest: bool) -> int:
    """Return the complex equations less unknowns of one fit."""
    return 2 * REACH + 1 - _CURVED - (0 if at_rest else _ENDS)


def _fit(x: Complex, y: Complex, at: NDArray[np.int64], at_rest: bool) -> tuple[Complex, Floats, Floats]:
    near_x, near_y = _near(x, at), _near(y, at)
    scale, power = _size(near_x)
    near_x = near_x / scale[:, np.newaxis]
    found = _smooth_or_sharp(near_x, near_y, 0 if at_rest else _ENDS)
    variance = found.variance
    if not at_rest:
        variance = variance + np.abs(_smooth_or_sharp(near_x, near_y, _CURVED).response - found.response) ** 2
    return found.response / scale, _relative(variance, found.response), power


def indirect_fit(r: Complex, x: Complex, y: Complex, at: NDArray[np.int64], *, at_rest: bool) -> IndirectFit:
    """Fit the response of bins `y` to bins `x` as the ratio of their responses to bins `r` of a stimulus.

    What noise a loop carries to both cancels in the residual of y less response times x, whose scatter is
    the variance (Pintelon and Schoukens, 7.2.7; Söderström and Stoica, System Identification, 8.2). It is
    that of the response, and relative to what the stimulus makes of the input, by the mean of neighbours:
    the residual is least for a response of -1 over the controller, and where noise enlarges the input it
    turns the response, so that frequencies picked by their own error would be turned on average.
    """
    parts = [_indirect(r, x, y, at[start : start + _BATCH], at_rest) for start in range(0, len(at), _BATCH)]
    of_x, of_y, power, xx, yy, xy = (np.concatenate(each) for each in zip(*parts, strict=True))
    response = of_y / of_x
    even = _even(response.real) + 1j * _even(response.imag)
    variance = yy - 2.0 * np.real(np.conj(even) * xy) + np.abs(even) ** 2 * xx
    size = np.abs(response) * np.exp(_even(np.log(np.abs(of_x))))
    return IndirectFit(response, _relative(np.maximum(variance, 0.0), size), power, xx / np.abs(of_x) ** 2)


def _indirect(
    r: Complex, x: Complex, y: Complex, at: NDArray[np.int64], at_rest: bool
) -> tuple[Complex, Complex, Floats, Floats, Floats, Complex]:
    """Return the responses of x and y to the stimulus, its power, their variances and their covariance."""
    near_r, near_x, near_y = (_near(bins, at) for bins in (r, x, y))
    scale, power = _size(near_r)
    near_r = near_r / scale[:, np.newaxis]
    ends = 0 if at_rest else _ENDS
    of_x, of_y = _smooth_or_sharp(near_r, near_x, ends), _smooth_or_sharp(near_r, near_y, ends)
    each = np.maximum(of_x.spread, of_y.spread) / np.minimum(of_y.freedom, of_x.freedom)
    xx, yy, xy = (
        np.sum(np.conj(one) * other, axis=1) * each
        for one, other in ((of_x.left, of_x.left), (of_y.left, of_y.left), (of_x.left, of_y.left))
    )
    if not at_rest:
        more_x, more_y = (
            _smooth_or_sharp(near_r, near, _CURVED).response - found.response
            for near, found in ((near_x, of_x), (near_y, of_y))
        )
        xx, yy = xx + np.abs(more_x) ** 2, yy + np.abs(more_y) ** 2
        xy = xy + np.conj(more_x) * more_y
    driven = np.where(of_x.response == 0.0, np.finfo(np.float64).tiny, of_x.response)
    return driven, of_y.response, power, xx.real, yy.real, xy


def _even(values: Floats) -> Floats:
    """Return means over neighbours."""
    from scipy import ndimage

    return np.asarray(ndimage.uniform_filter1d(values, _NEIGHBOURS, mode="nearest"))


def _near(bins: Complex, at: NDArray[np.int64]) -> Complex:
    return np.asarray(bins[at[:, np.newaxis] + np.arange(-REACH, REACH + 1)])


def _size(near: Complex) -> tuple[Floats, Floats]:
    """Return the rms and the mean power of bins, shape (m, width)."""
    power = np.mean(np.abs(near) ** 2, axis=1)
    return np.sqrt(np.maximum(power, np.finfo(np.float64).tiny)), power


def _relative(variance: Floats, response: Complex | Floats) -> Floats:
    """Return the standard uncertainty of one component relative to a response of a complex variance."""
    size = np.maximum(np.abs(response), np.finfo(np.float64).tiny)
    return np.asarray(np.sqrt(0.5 * variance) / size)


@dataclass(frozen=True)
class _Solution:
    """Response in the middle, shape (m,), what is left in each bin, (m, width), the degrees of freedom of
    that, and the variance of the response over that of a bin."""

    response: Complex
    left: Complex
    freedom: Floats
    spread: Floats

    @property
    def power_left(self) -> Floats:
        """Complex variance of a bin, by what is left in all."""
        return np.asarray(np.sum(np.abs(self.left) ** 2, axis=1) / self.freedom)

    @property
    def variance(self) -> Floats:
        """Complex variance of the response."""
        return self.power_left * self.spread

    def where(self, chosen: NDArray[np.bool_], other: _Solution) -> _Solution:
        """Return this one where `chosen`, shape (m,), and the other elsewhere."""
        return _Solution(
            np.where(chosen, self.response, other.response),
            np.where(chosen[:, np.newaxis], self.left, other.left),
            np.where(chosen, self.freedom, other.freedom),
            np.where(chosen, self.spread, other.spread),
        )


def _smooth_or_sharp(near_x: Complex, near_y: Complex, ends: int) -> _Solution:
    """Return the fit with `ends` terms of T, with a pole where that leaves much less, and there with a second
    one where that leaves much less again, or the response by it differs beyond chance from fit to fit."""
    smooth, sharp = (_solve(near_x, near_y, ends, poles) for poles in (0, 1))
    has_pole = smooth.variance > _SHARP * sharp.variance
    found = sharp.where(has_pole, smooth)
    if not np.any(has_pole):
        return found
    sharper = _solve(near_x, near_y, ends, 2)
    apart2 = np.abs(sharper.response - sharp.response) ** 2
    by_chance2 = sharper.power_left * np.maximum(0.0, sharper.spread - sharp.spread)
    has_two = sharp.variance > _SHARP * sharper.variance
    has_two |= _even(apart2) > _BEYOND_CHANCE * _even(by_chance2)
    return sharper.where(has_pole & has_two, found)


def _solve(near_x: Complex, near_y: Complex, ends: int, poles: int) -> _Solution:
    """Return the fit of a response with `poles` poles."""
    count, width = near_x.shape
    powers = np.linspace(-1.0, 1.0, width)[:, np.newaxis] ** np.arange(_CURVED)
    columns = np.empty((count, width, _CURVED + ends + poles), dtype=np.complex128)
    columns[:, :, :_CURVED] = near_x[:, :, np.newaxis] * powers
    columns[:, :, _CURVED : _CURVED + ends] = powers[:, :ends]
    columns[:, :, _CURVED + ends :] = -near_y[:, :, np.newaxis] * powers[:, 1 : 1 + poles]
    orthogonal, triangular = np.linalg.qr(columns)
    along = np.conj(orthogonal.transpose(0, 2, 1)) @ near_y[:, :, np.newaxis]
    left = near_y - (orthogonal @ along)[:, :, 0]
    first_row = _first_of_inverse(triangular)
    return _Solution(
        np.sum(first_row * along[:, :, 0], axis=1),
        left,
        np.full(count, float(width - columns.shape[2])),
        np.sum(np.abs(first_row) ** 2, axis=1),
    )


def _first_of_inverse(triangular: Complex) -> Complex:
    """Return the first row of the inverse of each upper triangular matrix, shape (count, n), by substitution;
    of one that is as good as singular that of its pseudo-inverse."""
    diagonal = np.abs(np.diagonal(triangular, axis1=1, axis2=2))
    regular = np.min(diagonal, axis=1) > _SINGULAR * np.max(diagonal, axis=1)
    found = np.zeros(triangular.shape[:2], dtype=np.complex128)
    with np.errstate(divide="ignore", invalid="ignore", over="ignore"):
        found[:, 0] = 1.0 / triangular[:, 0, 0]
        for at in range(1, triangular.shape[2]):
            known = np.vecdot(np.conj(found[:, :at]), triangular[:, :at, at])
            found[:, at] = -known / triangular[:, at, at]
    if not np.all(regular):
        found[~regular] = np.linalg.pinv(triangular[~regular])[:, 0, :]
    return found
