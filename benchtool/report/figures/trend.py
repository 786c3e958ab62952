"""A measurement over the cases of a plan: against what is swept, a line for each law or variant, or over
repetitions; each value with its expanded uncertainty, and the limits that it is judged by."""

from __future__ import annotations

import itertools
import math
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass

import numpy as np
from matplotlib.axes import Axes
from matplotlib.figure import Figure
from matplotlib.markers import CARETDOWNBASE
from matplotlib.ticker import FuncFormatter, MaxNLocator
from numpy.typing import NDArray

from benchtool.analysis import raw
from benchtool.report.figures.labels import measurement_label, swept_label
from benchtool.report.figures.limits import draw_limits
from benchtool.report.figures.style import (
    DASHES,
    LIMIT,
    SERIES,
    add_legend,
    dress,
    literal,
    new_figure,
)

REPETITION = "repetition"
"""The swept key of a plan that repeats one case."""

_DECADES = 20.0  # between the least and the greatest value, from which on the scale is logarithmic
_MARKERS = "os^vDPX"
_HEIGHT_IN = 4.2
_LONGEST = 14  # characters of names below an axis that stand upright


@dataclass(frozen=True)
class Point:
    """A value where `x` is swept to; a name stands for what has no number.

    `expanded` is its expanded uncertainty for 95 %, nan where it is not known. `single` are the repetitions
    whose mean the value is; `least` and `greatest` are the limits that it is judged by. Where `is_bound`, no
    more is known than that it is less than the value.
    """

    x: float | str
    value: float
    expanded: float = math.nan
    single: tuple[float, ...] = ()
    least: float | None = None
    greatest: float | None = None
    is_bound: bool = False


@dataclass(frozen=True)
class Trend:
    """One measurement over the cases of a plan; `key` is what is swept, empty where names stand below the
    axis."""

    measurement: str
    unit: str
    key: str
    series: Mapping[str, tuple[Point, ...]]


def draw_trend(trend: Trend, title: str) -> Figure:
    """Return the values of each series with bars of expanded uncertainty, small dots for single repetitions,
    and a dashed line at each limit; on a logarithmic scale where values differ by more than a factor of
    twenty."""
    points = [point for series in trend.series.values() for point in series]
    uncertain = any(math.isfinite(point.expanded) for point in points)
    summary = "bars: expanded uncertainty (95 %)" if uncertain else ""
    if any(point.single for point in points):
        summary = f"mean of repetitions, which are the small dots{'; ' if summary else ''}{summary}"
    if any(point.is_bound for point in points):
        summary = f"{summary}{'; ' if summary else ''}triangles: less than at their base"
    figure = new_figure(_HEIGHT_IN, title, summary)
    axes = figure.subplots()
    names = list(dict.fromkeys(point.x for point in points if isinstance(point.x, str)))
    apart = _apart([_place(point, names) for point in points], len(trend.series)) if uncertain else 0.0
    looks = zip(itertools.cycle(SERIES), itertools.cycle(_MARKERS), itertools.cycle(DASHES))
    middle = 0.5 * (len(trend.series) - 1)
    for number, ((name, series), look) in enumerate(zip(trend.series.items(), looks, strict=False)):
        x = np.array([_place(point, names) + apart * (number - middle) for point in series])
        _draw_series(axes, x, series, name, look, joined=not names)
    _scale(axes, points)
    _draw_limits(axes, trend, names)
    dress(axes, _x_label(trend), measurement_label(trend.measurement, trend.unit))
    if names:
        upright = max(map(len, names)) > _LONGEST
        axes.set_xticks(range(len(names)), [literal(name) for name in names], rotation=30 if upright else 0)
        for text in axes.get_xticklabels():
            text.set_horizontalalignment("right" if upright else "center")
    elif trend.key == REPETITION:
        axes.xaxis.set_major_locator(MaxNLocator(integer=True))
    if len(trend.series) > 1 or axes.get_legend_handles_labels()[1] != list(trend.series):
        add_legend(axes)
    return figure


def _draw_series(
    axes: Axes,
    x: NDArray[np.float64],
    series: Sequence[Point],
    name: str,
    look: tuple[str, str, tuple[float, tuple[float, ...]]],
    *,
    joined: bool,
) -> None:
    """Values with their bars and, beneath, single repetitions; a line joins what has numbers below the
    axis. A value that is only known to be less than a bound has a triangle down from there."""
    color, marker, dashes = look
    order = np.argsort(x, kind="stable")
    values = np.array([math.nan if point.is_bound else point.value for point in series])
    bars = np.nan_to_num([point.expanded for point in series])[order]
    axes.errorbar(
        *(x[order], values[order], bars if bars.any() else None),
        label=literal(name),
        color=color,
        marker=marker,
        markersize=4,
        linewidth=1.1,
        linestyle=dashes if joined else "",
        elinewidth=0.9,
        capsize=2.5,
    )
    bounds = [(place, point.value) for place, point in zip(x, series, strict=True) if point.is_bound]
    if bounds:
        axes.plot(*zip(*bounds, strict=True), color=color, marker=CARETDOWNBASE, markersize=7, linestyle="")
    for place, point in zip(x, series, strict=True):
        axes.plot([place] * len(point.single), point.single, ".", color=color, markersize=3, alpha=0.45)


def _place(point: Point, names: Sequence[str]) -> float:
    return float(names.index(point.x)) if isinstance(point.x, str) else point.x


def _apart(places: Sequence[float], count: int) -> float:
    """Return how far the series stand beside each other, so that their bars can be told apart."""
    steps = np.diff(np.unique(places))
    return 0.25 * float(min(steps, default=1.0)) / max(count, 4)


def _x_label(trend: Trend) -> str:
    return trend.key if trend.key in ("", REPETITION) else swept_label(trend.key)


def _scale(axes: Axes, points: Sequence[Point]) -> None:
    values = [point.value for point in points if math.isfinite(point.value)]
    if values and min(values) > 0.0 and max(values) > _DECADES * min(values):
        axes.set_yscale("log")
        axes.yaxis.set_major_formatter(FuncFormatter(lambda value, _: raw(value, 6)))


def _draw_limits(axes: Axes, trend: Trend, names: Sequence[str]) -> None:
    """A line across the axes for a limit that all points share, else a short one at each point."""
    bounds = [
        (point, bound) for series in trend.series.values() for point in series for bound in _bounds(point)
    ]
    shared = {bound for _, bound in bounds}
    count = sum(len(series) for series in trend.series.values())
    if all(sum(one == bound for _, one in bounds) == count for bound in shared):
        draw_limits(
            axes, [(bound, f"limit {raw(bound, 6)} {trend.unit}".rstrip()) for bound in sorted(shared)]
        )
        return
    places = sorted({_place(point, names) for series in trend.series.values() for point in series})
    half = 0.35 * min(np.diff(places), default=1.0)
    look = {**LIMIT, "linestyle": "-"}
    for number, (point, bound) in enumerate(
        dict.fromkeys((_place(point, names), bound) for point, bound in bounds)
    ):
        axes.plot([point - half, point + half], [bound, bound], label="" if number else "limit", **look)


def _bounds(point: Point) -> Iterator[float]:
    yield from (bound for bound in (point.least, point.greatest) if bound is not None)
