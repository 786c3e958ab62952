"""Harmonic groups and interharmonic subgroups over short windows, after IEC 61000-4-7:2002+A1:2008."""

from __future__ import annotations

import math
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from numpy import fft
from numpy.lib.stride_tricks import sliding_window_view
from numpy.typing import NDArray

from benchtool.analysis.coherent.spectrum import CoherentSamples
from benchtool.analysis.measurement import Basis, Table
from benchtool.analysis.numbers import count_of
from benchtool.analysis.statistics.scatter import MeanError, error_of_series
from benchtool.analysis.uncertainty import Contribution

Kind = Literal["group", "subgroup"]

PERIODS_PER_WINDOW = 10
"""The standard's window at 50 Hz: 200 ms there, ten periods of the machine here, however long they are."""

FEWEST_WINDOWS = 3
"""Fewest windows whose scatter says how much a number varies."""

_FEWEST_PERIODS = 4  # with fewer, subgroups overlap and there are no bins between them
_RARELY = 0.02
_LAGS, _SURELY = 16, 3.0  # rows within which a click is alike; standard deviations
_BEGINS = 8  # as many tell what goes with the phase, and with twice that, over a few periods
_GOLDEN = 0.5 * (math.sqrt(5.0) - 1.0)  # its multiples, less whole ones, are evenly spread however many
_BATCH = 1 << 18  # samples transformed at a time


@dataclass(frozen=True)
class HarmonicGroups:
    """Squares of rms values, all of shape (windows, orders), of orders 1, 2, 3 ...

    Of a window of N = `periods_per_window` periods, with C_i the rms of DFT bin i:
    group of order h: bins N h - N/2 to N h + N/2, the two ends by half of their square;
    subgroup: bins N h - 1 to N h + 1; interharmonic centred subgroup: bins N h + 2 to N (h + 1) - 2, between
    order h and the next. `beside2`, shape (windows, bins), are the C_i^2 without the lines, which are the
    means of the phasors of bins N h over the windows.
    """

    group2: NDArray[np.float64]
    subgroup2: NDArray[np.float64]
    interharmonic2: NDArray[np.float64]
    beside2: NDArray[np.float64]
    periods_per_window: int

    @property
    def windows(self) -> int:
        return len(self.group2)

    @property
    def orders(self) -> int:
        return int(self.group2.shape[1])

    def of(self, kind: Kind) -> NDArray[np.float64]:
        """Return the squares of groups or of subgroups."""
        return self.group2 if kind == "group" else self.subgroup2

    def shares(self, kind: Kind, weights: NDArray[np.float64]) -> NDArray[np.float64]:
        """Return how much each bin counts, shape (bins,), in a sum of the squares of all orders, each by its
        weight, shape (orders,)."""
        periods, found = self.periods_per_window, np.zeros(self.beside2.shape[1])
        for offset, share in _members(kind, periods):
            found[periods * np.arange(1, self.orders + 1) + offset] += share * weights
        return found


@dataclass(frozen=True)
class GroupDistortion:
    """A distortion as a ratio to the fundamental's group, and its budget, also of ratios."""

    ratio: float
    budget: tuple[Contribution, ...] = ()

    @property
    def standard(self) -> float:
        """Standard uncertainty; nan where it is not known."""
        return math.sqrt(sum(each.standard**2 for each in self.budget))


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
    lines = np.empty((windows, orders), dtype=np.complex128)
    batch = max(1, _BATCH // size)
    for start in range(0, windows, batch):
        transformed = fft.rfft(table[start : start + batch], axis=1)[:, : bins + 1]
        squares[start : start + batch] = transformed.real**2 + transformed.imag**2
        lines[start : start + batch] = transformed[:, periods:bins:periods]
    squares *= 2.0 / size**2  # rms; dc, which would be by half of that, is in no group
    found = groups_of(squares, periods, orders)
    squares[:, periods:bins:periods] = 2.0 / size**2 * np.abs(lines - np.mean(lines, axis=0)) ** 2
    return found


def groups_of(squares: NDArray[np.float64], periods: int, orders: int) -> HarmonicGroups:
    """Return the groups of squares of the rms of bins, shape (windows, bins), of windows of `periods`; they
    stand for `beside2` too."""

    before, after = max(1, periods // 2), max(1, periods // 2, periods - 2)
    shares = np.zeros((before + 1 + after, 3))
    between = ((offset, 1.0) for offset in range(2, periods - 1))
    for kind, members in enumerate((_members("group", periods), _members("subgroup", periods), between)):
        for offset, share in members:
            shares[before + offset, kind] = share
    around = sliding_window_view(squares, len(shares), axis=1)[:, periods - before :: periods][:, :orders]
    group2, subgroup2, interharmonic2 = np.moveaxis(around @ shares, 2, 0)
    return HarmonicGroups(group2, subgroup2, interharmonic2, squares, periods)


def _members(kind: Kind, periods: int) -> Iterator[tuple[int, float]]:
    """Yield the bins of a group from its order on, and how much of their square is in it."""
    within = 1 if kind == "subgroup" else (periods - 1) // 2
    for offset in range(-within, within + 1):
        yield offset, 1.0
    if kind == "group" and periods % 2 == 0:  # the bin halfway belongs to both neighbours
        yield -(periods // 2), 0.5
        yield periods // 2, 0.5


def ratio_of(squares: NDArray[np.float64]) -> float:
    """Return THDG or THDS of squares of rms, shape (windows, orders)."""
    mean = np.mean(squares, axis=0)
    return math.sqrt(float(np.sum(mean[1:]) / mean[0])) if mean[0] > 0.0 else math.nan


def scatter_of_bursts(coherent: CoherentSamples) -> float:
    """Return the relative standard uncertainty of the power of what no period repeats, by how much more it
    scatters than that of normal noise of the same spectrum: of few clicks, by the root of their number.

    A click is in all bins alike, whose powers show nothing of it. The square of normal noise has twice the
    square of its autocovariance.
    """
    values = coherent.values.reshape(coherent.periods, coherent.per_period)
    left = (values - np.mean(values, axis=0)).ravel()
    power = left**2
    mean2 = float(np.mean(power))
    if not mean2 > 0.0:
        return 0.0
    about, beyond, alike = power - mean2, 0.0, 0.0
    for lag in range(min(_LAGS, len(left))):
        pairs, sides = len(left) - lag, 2.0 if lag else 1.0
        of_normal = float(left[:pairs] @ left[lag:] / len(left)) ** 2
        beyond += sides * (float(about[:pairs] @ about[lag:]) / len(left) - 2.0 * of_normal)
        alike += sides * of_normal / mean2**2
    # of normal noise the variances of the fourth cumulant and of products of two squares, lag by lag
    by_chance = _SURELY * math.sqrt((24.0 + 16.0 * (_LAGS - 1)) / len(left)) * alike
    return math.sqrt(beyond / len(left)) / mean2 if beyond > by_chance * mean2**2 else 0.0


def power_beside_lines(groups: HarmonicGroups, kind: Kind, of_bursts: float = 0.0) -> MeanError:
    """Return the error of THDG or THDS by what is beside the lines in the groups, or moves these.

    Of its power, less what order 1 has of it by its share, the scatter over the windows tells how well the
    mean is known: by few degrees of freedom. The power of a bin of noise is distributed exponentially, and
    each bin by itself: the scatter of each over the windows, in one window half of its square, tells it by
    many bins. Both count by their degrees of freedom, unless they differ by more than chance: then the
    scatter of all together does, because bursts are in all bins at once, and lines that beat are in few.
    Few windows do not show that, and what `of_bursts` is relative to the power is added.
    """
    squares, power = groups.of(kind), groups.beside2
    ratio, windows = ratio_of(squares), len(squares)
    shares = np.full(groups.orders, 1.0)
    shares[0] = -(ratio**2)
    # what the power of each bin makes of the ratio
    slopes = groups.shares(kind, shares) / (2.0 * ratio * float(np.mean(squares[:, 0])))
    scatter2 = np.var(power, axis=0, ddof=1) if windows > 1 else 0.5 * power[0] ** 2
    of_bins = slopes**2 * scatter2 / windows
    square, fourth = float(np.sum(of_bins)), float(of_bins @ of_bins)
    dof = max(1.0, 2.0 * square**2 / fourth) if fourth > 0.0 else math.inf
    apart = MeanError.of_scatter(math.sqrt(square), dof)
    each = power @ slopes
    if windows < FEWEST_WINDOWS:
        return replace(apart, standard=math.hypot(apart.standard, of_bursts * float(np.mean(each))))
    together = error_of_series(each)
    if not math.isfinite(together.standard):  # they wander together: their mean is as good as one of them
        return MeanError(min(apart.standard, float(np.std(each))), windows - 1.0)
    return together if apart.exceeds_by_chance(together) < _RARELY else together.pooled_with_noise(apart)


def scatter_of_begins(coherent: CoherentSamples, highest_harmonic: int) -> Mapping[Kind, float]:
    """Return the standard deviation of THDG and THDS over where in a period, and in which of those that are
    left over, the windows begin; 0 where none is left that may begin elsewhere.

    What is not the same at both ends of a window leaks, by the phase there of the current, or of a line
    between the harmonics against them. It is the same in all windows of a record, or turns by as much from
    one to the next: their scatter does not show it.
    """
    periods = min(PERIODS_PER_WINDOW, coherent.periods)
    windows = (coherent.periods - 1) // periods
    spare = coherent.periods - windows * periods
    found: dict[Kind, list[float]] = {"group": [], "subgroup": []}
    for number in range(_BEGINS if windows else 0):
        later = math.floor(spare * (number * _GOLDEN % 1.0))  # periods
        begin = round((later + number / _BEGINS) * coherent.per_period)
        part = replace(
            coherent,
            values=coherent.values[begin : begin + windows * periods * coherent.per_period],
            periods=windows * periods,
            samples=coherent.samples * windows * periods / coherent.periods,
        )
        groups = harmonic_groups(part, highest_harmonic)
        for kind, ratios in found.items():
            ratios.append(math.nan if groups is None else ratio_of(groups.of(kind)))
    return {kind: float(np.std(ratios)) if ratios else 0.0 for kind, ratios in found.items()}


def group_distortion(
    groups: HarmonicGroups,
    kind: Kind,
    by_noise: MeanError | None = None,
    of_order_1: float = 0.0,
    of_lines: float = 0.0,
    of_bursts: float = 0.0,
) -> GroupDistortion:
    """Return sqrt(sum over h = 2 ... H of Y_h^2) / Y_1: THDG or THDS.

    Each Y_h^2 is the mean over the windows. What lies beside a line of the record, at k cycles over all
    windows together, adds to it in one window and is taken off it in another, and in the mean it is gone: the
    lines of these groups are those of the record, and have their noise, which makes of a ratio `of_lines`
    alone `by_noise`, with `of_order_1`, the relative uncertainty of Y_1. What remains of all else is its
    power, which bursts make uncertain by as much relative to it. Where the noise is not known the ratio of
    each window tells both.
    """
    squares = groups.of(kind)
    ratio, windows = ratio_of(squares), len(squares)
    if groups.orders < 2 or not ratio > 0.0:
        return GroupDistortion(math.nan if groups.orders < 2 else ratio)
    if by_noise is None or not math.isfinite(by_noise.standard):
        each = np.sqrt(np.sum(squares[:, 1:], axis=1) / np.maximum(squares[:, 0], 1e-300))
        return GroupDistortion(
            ratio, (error_of_series(each).line(f"scatter over {count_of(windows, 'window')}"),)
        )
    # what is in the groups beside the lines makes of the same noise less of a ratio
    share = min(1.0, of_lines / ratio) if of_lines > 0.0 else 1.0
    lines = math.hypot(share * by_noise.standard, ratio * of_order_1)
    beside = power_beside_lines(groups, kind, of_bursts)
    budget = (
        Contribution("noise in the harmonics", "A", lines, by_noise.dof),
        beside.line(f"power beside the harmonics in {count_of(windows, 'window')}"),
    )
    return GroupDistortion(ratio, budget)


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
        f"rms over {count_of(groups.windows, 'window')} of N = {periods} periods, after "
        f"IEC 61000-4-7:2002+A1:2008; group of order h: bins N h - N/2 to N h + N/2, ends by half of their "
        f"square; subgroup: N h - 1 to N h + 1; interharmonic centred subgroup: N h + 2 to N (h + 1) - 2",
        (("order", ""), ("group_rms", unit), ("subgroup_rms", unit), ("interharmonic_rms", unit)),
        tuple(tuple(float(value) for value in row) for row in zip(order, *rms, strict=True)),
        basis,
    )
