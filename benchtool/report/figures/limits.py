"""Limits as figures show them: dashed lines at what the plan judges by, and the bound beside a number."""

from __future__ import annotations

from collections.abc import Iterable

from matplotlib.axes import Axes

from benchtool.analysis import Measurement, Panel, raw
from benchtool.report.figures.style import LIMIT


def draw_limits(axes: Axes, levels: Iterable[tuple[float, str]]) -> None:
    """A line at each level; levels that mean the same have one entry in the legend."""
    told: set[str] = set()
    for level, meaning in levels:
        axes.axhline(level, zorder=2.8, label="_nolegend_" if meaning in told else meaning, **LIMIT)
        told.add(meaning)


def stated_with_limit(measured: Measurement, panel: Panel) -> str:
    """Return a value with its unit and, where it is judged, its bounds: `0.0498 Nm (limit 0.06)`."""
    text = f"{raw(measured.value, 3)} {measured.unit}".rstrip()
    least, greatest = panel.limits.get(measured.name, (None, None))
    bounds = [raw(bound) for bound in (least, greatest) if bound is not None]
    return f"{text} (limit {' to '.join(bounds)})" if bounds else text
