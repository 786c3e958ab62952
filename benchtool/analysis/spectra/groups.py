"""Harmonic groups and interharmonic subgroups over short windows, after IEC 61000-4-7:2002+A1:2008."""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np
from numpy import fft
from numpy.typing import NDArray

from benchtool.analysis.distributions import students_deviation
from benchtool.analysis.measurement import Basis, Table
from benchtool.analysis.scatter import MeanError, error_of_series
from benchtool.analysis.spectra.spectrum import CoherentSamples

PERIODS_PER_WINDOW = 10
"""The standard's window at 50 Hz: 200 ms there, ten periods of the machine here, however long they are."""

FEWEST_WINDOWS = 3
"""Fewest windows whose scatter says how much a number varies."""

_FEWEST_PERIODS = 4  # with fewer, subgroups overlap and there are no bins between them
_OF_EXCESS = 0.7
_BY_CHANCE, _RARELY = 0.1, 0.02
_BATCH = 1 << 18  # samples transformed at a time


@dataclass(frozen=True)
class HarmonicGroups:
    """Squares of rms values, all of shape (windows, orders), of orders 1, 2, 3 ...

    Of a window of N = `periods_per_window` periods, with C_i the rms of DFT bin i:
    group of order h: bins N h - N/2 to N h + N/2, the two ends by half of their square;
    subgroup: bins N h - 1 to N h + 1; interharmonic centred subgroup: bins N h + 2 to N (h + 1) - 2, between
    order h and the next.
    """

    group2: NDArray[np.float64]
    subgroup2: NDArray[np.float64]
    interharmonic2: NDArray[np.float64]
    periods_per_window: int

    @property
    def windows(self) -> int:
        return len(self.group2)

    @property
    def orders(self) -> int:
        return int(self.group2.shape[1])


@dataclass(frozen=True)
class GroupDistortion:
    """A distortion as a ratio to the fundamental's group, and its standard uncertainty; nan if unknown."""

    ratio: float
    standard: float
    dof: float = math.nan


def harmonic_groups(
    coherent: CoherentSamples, highest_harmonic: int, periods_per_window: int = PERIODS_PER_WINDOW
) -> HarmonicGroups | None:
    """Return the groups of successive windows without overlap, rectangular; None if there is no order or no
    window.

    With fewer periods than `periods_per_window` one window takes them all, and four are the fewest; periods
    after the last whole window are left out. The highest order is the last one whose interharmonics are in
    the band. The standard's low-pass filter of 1.5 s over the windows is left out.
    """
    periods = min(periods_per_window, coherent.periods)
    orders = min(highest_harmonic, math.floor(coherent.usable_order - 1.0))
    if periods < _FEWEST_PERIODS or orders < 1:
        return None
    windows, size = coherent.periods // periods, periods * coherent.per_period
    table = coherent.values[: windows * size].reshape(windows, size)
    bins = (orders + 1) * periods
    squares = np.empty((windows, bins + 1))
    batch = max(1, _BATCH // size)
    for start in range(0, windows, batch):
        transformed = fft.rfft(table[start : start + batch], axis=1)[:, : bins + 1]
        squares[start : start + batch] = transformed.real**2 + transformed.imag**2
    squares *= 2.0 / size**2  # rms; dc, which would be by half of that, is in no group
    return groups_of(squares, periods, orders)


def groups_of(squares: NDArray[np.float64], periods: int, orders: int) -> HarmonicGroups:
    """Return the groups of squares of the rms of bins, shape (windows, bins), of windows of `periods`."""
    at = periods * np.arange(1, orders + 1)

    def total(first: int, last: int) -> NDArray[np.float64]:
        sums = np.zeros((len(squares), orders))
        for offset in range(first, last + 1):
            sums += squares[:, at + offset]
        return sums

    within = (periods - 1) // 2
    group2 = total(-within, within)
    if periods % 2 == 0:  # the bin halfway belongs to both neighbours
        group2 += 0.5 * (squares[:, at - periods // 2] + squares[:, at + periods // 2])
    return HarmonicGroups(group2, total(-1, 1), total(2, periods - 2), periods)


def ratio_of(squares: NDArray[np.float64]) -> float:
    """Return THDG or THDS of squares of rms, shape (windows, orders)."""
    mean = np.mean(squares, axis=0)
    return math.sqrt(float(np.sum(mean[1:]) / mean[0])) if mean[0] > 0.0 else math.nan


def scatter_of_power(groups: HarmonicGroups, squares: NDArray[np.float64]) -> float:
    """Return the standard uncertainty of THDG or THDS of squares of rms, shape (1, orders), of one window, by
    the power of the noise in their bins beside the lines.

    The power of a bin of noise is distributed exponentially: it scatters by as much as it is, which the bins
    between subgroups tell, of the orders to both sides. A mean of m of them has 1 + 1 / m times its square.
    """
    between, ratio = groups.periods_per_window - 3, ratio_of(squares)
    if len(squares) > 1 or between < 1 or not ratio > 0.0:
        return 0.0
    each = groups.interharmonic2[0] / between
    around = 0.5 * (each[1:] + each[:-1])
    bins = groups.periods_per_window - 1 if squares is groups.group2 else 2
    square2 = bins * float(np.sum(around**2)) / (1.0 + 0.5 / between)
    return math.sqrt(square2) / (2.0 * ratio * float(squares[0, 0]))


def group_distortion(
    squares: NDArray[np.float64],
    by_noise: MeanError | None = None,
    of_order_1: float = 0.0,
    of_lines: float = 0.0,
) -> GroupDistortion:
    """Return sqrt(sum over h = 2 ... H of Y_h^2) / Y_1 of squares of rms, shape (windows, orders): THDG or
    THDS.

    Each Y_h^2 is the mean over the windows. The uncertainty is by the variance that two estimates have in
    common, weighted by their degrees of freedom: `by_noise`, what the noise beside the lines makes of a ratio
    `of_lines` alone, with `of_order_1`, the relative uncertainty of Y_1; and the scatter of the squares of
    the orders over the windows, each taken as independent, which alone counts where it is more (F-test, one
    in ten by chance): it is of all that is in the groups. The ratio of each window
    scatters with what the orders have in common, but of few windows by few degrees of freedom: that counts
    where it is more than the others explain (F-test, one in ten by chance), or so much less than the orders'
    (one in fifty) that they share what they scatter by. What the groups have beyond the lines, whose ratio is
    `of_lines`, then counts by 0.7 of itself: it is of few events, whose scatter few windows do not show.
    """
    ratio, windows = ratio_of(squares), len(squares)
    if squares.shape[1] < 2 or math.isnan(ratio):
        return GroupDistortion(math.nan, math.nan)
    noise = by_noise or MeanError(math.nan, math.nan)
    # what is in the groups beside the lines makes of the same noise less of a ratio
    share = min(1.0, of_lines / ratio) if of_lines > 0.0 and ratio > 0.0 else 1.0
    noise = MeanError(math.hypot(share * noise.standard, ratio * of_order_1), noise.dof)
    if windows < 2 or not np.all(squares[:, 0] > 0.0) or not ratio > 0.0:
        return GroupDistortion(ratio, noise.standard, noise.dof)
    each = np.sqrt(np.sum(squares[:, 1:], axis=1) / squares[:, 0])
    together = error_of_series(each) if windows >= FEWEST_WINDOWS else MeanError(math.nan, math.nan)
    variance = np.var(squares / np.mean(squares[:, 0]), axis=0, ddof=1) / windows
    variance[0] *= ratio**4
    apart = math.sqrt(float(np.sum(variance))) / (2.0 * ratio)
    fourth = float(np.sum(variance**2))
    dof = (windows - 1) * float(np.sum(variance)) ** 2 / fourth if fourth > 0.0 else math.inf
    dof = max(1.0, dof)
    if math.isfinite(together.standard) and _exceeds(MeanError(apart, dof), together, _RARELY):
        # what all orders do alike cancels
        apart, dof = min(apart, max(together.standard, _OF_EXCESS * (ratio - of_lines))), together.dof
    if math.isfinite(noise.standard):
        found = _pooled(MeanError(apart, dof), noise)
    else:
        found = MeanError(apart * students_deviation(dof), dof)
    if math.isfinite(together.standard) and _exceeds(together, found):
        found = together
    return GroupDistortion(ratio, found.standard, max(1.0, found.dof))


def _pooled(scatter: MeanError, noise: MeanError) -> MeanError:
    """Return the scatter where it is more than noise explains, else the variance that both are estimates
    of."""
    if _exceeds(scatter, noise):
        return scatter
    dof = scatter.dof + noise.dof
    if not math.isfinite(dof):
        return noise if math.isinf(noise.dof) else scatter
    square = (scatter.dof * scatter.standard**2 + noise.dof * noise.standard**2) / dof
    return MeanError(math.sqrt(square), dof)


def _exceeds(one: MeanError, other: MeanError, by_chance: float = _BY_CHANCE) -> bool:
    """Return whether a standard uncertainty is more than another by more than chance."""
    from scipy.special import fdtri  # which takes long to load, and few records ask for

    quantile = fdtri(one.dof, min(other.dof, 1e9), 1.0 - by_chance)
    return bool(one.standard**2 > quantile * other.standard**2)


def group_table(groups: HarmonicGroups, name: str, unit: str, basis: Basis) -> Table:
    """Return one order a row: rms over the windows of group, subgroup and interharmonic centred subgroup."""
    rms = [
        np.sqrt(np.mean(squares, axis=0))
        for squares in (groups.group2, groups.subgroup2, groups.interharmonic2)
    ]
    order = np.arange(1, groups.orders + 1)
    periods = groups.periods_per_window
    return Table(
        name,
        f"rms over {groups.windows} windows of N = {periods} periods, after IEC 61000-4-7:2002+A1:2008; "
        f"group of order h: bins N h - N/2 to N h + N/2, ends by half of their square; subgroup: N h - 1 to "
        f"N h + 1; interharmonic centred subgroup: N h + 2 to N (h + 1) - 2",
        (("order", ""), ("group_rms", unit), ("subgroup_rms", unit), ("interharmonic_rms", unit)),
        tuple(tuple(float(value) for value in row) for row in zip(order, *rms, strict=True)),
        basis,
    )
