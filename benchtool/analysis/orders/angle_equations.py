"""Normal equations of sines of all orders on uneven angles, by groups of revolutions."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from numpy.typing import NDArray

from benchtool.analysis.orders.angle import AngleCoverage

MOST_GROUPS = 1000
"""Groups of revolutions that are held in memory, each with the sums of all orders."""

_WORST_CONDITION = 0.2  # least eigenvalue of the normal matrix, 1 for even coverage
_PIECE = 256  # samples whose powers stay in the cache


@dataclass(frozen=True)
class Equations:
    """Equations of the unknowns c of exp(1j k angle), k = -K ... K, by groups of revolutions: `factor` of
    their sum, whose right-hand sides are `right`, shape (groups, 2 K + 1). `of_weights` has the sums of
    weights of orders up to 2 K, and `share` the weight of each group."""

    factor: tuple[NDArray[np.complex128], bool]
    of_weights: NDArray[np.complex128]
    share: NDArray[np.float64]
    right: NDArray[np.complex128]

    @classmethod
    def of(cls, sums: NDArray[np.complex128], products: NDArray[np.complex128], order: int) -> Equations:
        """Return the equations of so many orders."""
        from scipy.linalg import cho_factor

        factor = cho_factor(_normal(sums.sum(axis=0), order))
        right = _both_sides(products[:, : order + 1])
        return cls(factor, _both_sides(sums[:, : 2 * order + 1]), np.real(sums[:, 0]), right)

    @property
    def order(self) -> int:
        """Return the highest order, K."""
        return int(self.right.shape[1] // 2)

    def less(self, products: NDArray[np.complex128]) -> Equations:
        """Return those of the values without others, of which the sums of products are these."""
        return replace(self, right=self.right - _both_sides(products))

    def solved(self) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
        """Return the unknowns, and what each group has beside them, shape (groups, 2 K + 1): it adds up to
        zero."""
        from scipy.signal import fftconvolve  # draws in scipy.stats, which takes longer than all else here

        unknowns = self.moved_by(self.right.sum(axis=0))
        explained = fftconvolve(self.of_weights, unknowns[np.newaxis], "valid", axes=1)
        return unknowns, self.right - explained

    def moved_by(self, right: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """Return by how much right-hand sides, shape (2 K + 1, ...), move the unknowns."""
        from scipy.linalg import cho_solve

        return np.asarray(cho_solve(self.factor, right))


def groups_of(coverage: AngleCoverage) -> tuple[NDArray[np.int64], int]:
    """Return the group of each value, a revolution or some of them where they are many, and their number."""
    last = int(coverage.revolution.max())
    rows = min(last + 1, MOST_GROUPS)
    return coverage.revolution * rows // (last + 1), rows


def sums_of(
    coverage: AngleCoverage,
    weights: NDArray[np.float64],
    values: NDArray[np.float64],
    order: int,
    first: float = 0.0,
) -> tuple[NDArray[np.complex128], NDArray[np.complex128]]:
    """Return sums of w exp(-1j m angle), m = f ... f + 2 `order`, and of w x exp(-1j m angle), m = f ... f +
    `order`, with the `first` order f.

    A row for each revolution, or for each group of them where they are many.
    """
    group, rows = groups_of(coverage)
    sums = np.zeros((rows, 2 * order + 1), dtype=np.complex128)
    products = np.zeros((rows, order + 1), dtype=np.complex128)
    weighted = weights * values
    powers = np.empty((2 * order + 1, _PIECE), dtype=np.complex128)
    in_order = np.argsort(group, kind="stable")  # a rotor that turns back visits one twice
    bounds = np.concatenate(([0], np.cumsum(np.bincount(group, minlength=rows))))
    for row in range(rows):
        for begin in range(bounds[row], bounds[row + 1], _PIECE):
            piece = in_order[begin : min(begin + _PIECE, bounds[row + 1])]
            filled = powers[:, : len(piece)]
            _raise(np.exp(-1j * coverage.angle_rad[piece]), filled)
            if first:
                filled *= np.exp(-1j * first * coverage.angle_rad[piece])
            # not a matrix product, whose threads cost more than they save on pieces of this size
            sums[row] += np.vecdot(weights[piece], filled)
            products[row] += np.vecdot(weighted[piece], filled[: order + 1])
    visited = bounds[1:] > bounds[:-1]
    return sums[visited], products[visited]


def coefficients_of_all(
    coverage: AngleCoverage, weights: NDArray[np.float64], values: NDArray[np.float64], order: int
) -> NDArray[np.complex128]:
    """Return the coefficients of orders 1 to `order` of many signals at the same angles, shape (signals, n):
    shape (signals, order), for little more than those of one take."""
    sums = np.zeros(2 * order + 1, dtype=np.complex128)
    products = np.zeros((len(values), order + 1), dtype=np.complex128)
    powers = np.empty((2 * order + 1, _PIECE), dtype=np.complex128)
    for begin in range(0, len(weights), _PIECE):
        piece = slice(begin, min(begin + _PIECE, len(weights)))
        filled = powers[:, : piece.stop - begin]
        _raise(np.exp(-1j * coverage.angle_rad[piece]), filled)
        sums += filled @ weights[piece]
        products += (weights[piece] * values[:, piece]) @ filled[: order + 1].T
    equations = Equations.of(sums[np.newaxis], products, order)
    return equations.moved_by(equations.right.T)[order + 1 :].T


def _raise(base: NDArray[np.complex128], powers: NDArray[np.complex128]) -> None:
    """Fill `powers`, shape (count, n), with powers 0 to `count` - 1, each the product of two known ones."""
    powers[0] = 1.0
    powers[1:2] = base
    known = 2
    while known < len(powers):
        more = min(known - 1, len(powers) - known)
        np.multiply(powers[known - 1], powers[1 : more + 1], out=powers[known : known + more])
        known += more


def _both_sides(sums: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """Return the rows of sums for m = 0 ... n, shape (rows, n + 1), as rows for m = -n ... n: the signals are
    real."""
    return np.concatenate([np.conj(sums[:, :0:-1]), sums], axis=1)


def is_well_conditioned(sums: NDArray[np.complex128], order: int) -> bool:
    """Return whether sums of all groups, shape (2 K + 1,), determine so many orders, up to K: no eigenvalue
    of their normal matrix is below a limit, so that what is left of it is positive, and Cholesky succeeds."""
    normal = _normal(sums, order)
    try:
        np.linalg.cholesky(normal - _WORST_CONDITION * np.eye(len(normal)))
    except np.linalg.LinAlgError:
        return False
    return True


def _normal(sums: NDArray[np.complex128], order: int) -> NDArray[np.complex128]:
    """Return the normal matrix of unknowns -order ... order: row j, column k is the sum of w exp(1j (k - j)
    angle)."""
    from scipy.linalg import toeplitz

    return np.asarray(toeplitz(sums[: 2 * order + 1], np.conj(sums[: 2 * order + 1])))
