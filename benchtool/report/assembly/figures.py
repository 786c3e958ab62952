"""Figures of a run: one case alone, and all of them side by side."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from benchtool.analysis import Panel, catalogue
from benchtool.plan import Plan
from benchtool.recording import enlist
from benchtool.report.assembly.trends import trend_names, trend_of
from benchtool.report.figures.drawings import draw_of_case, draw_side_by_side
from benchtool.report.figures.files import save_figures
from benchtool.report.figures.trend import draw_trend
from benchtool.results import Assessment


def draw_case(plan: Plan, result: Assessment) -> None:
    """Write the figures of one case into its bundle."""
    enlist(result.bundle, save_figures(case_figures(plan.title, result), result.bundle / "plots"))


def case_figures(title: str, result: Assessment, most: int | None = None) -> dict[str, Figure]:
    """Return figures of one case by name: those of every analysis that was made, or the first few of them."""
    return draw_of_case(panel_of(result), title, most)


def panel_of(result: Assessment, label: str = "") -> Panel:
    """Return a case as a panel, by default labelled with its main results."""
    return Panel(
        label or _label(result),
        result.capture,
        result.steady,
        label or result.case,
        result.transducer,
        result.findings,
        {name: (limit.min, limit.max) for name, limit in result.limits.items()},
    )


def _label(result: Assessment) -> str:
    """Return the name of a case with its main results."""
    found = {each.name: each for each in result.measurements if math.isfinite(each.value)}
    labels = ((name, each.label) for each in catalogue().quantities for name in each.names if each.label)
    parts = (f"{label} {found[name].value:.3g} {found[name].unit}" for name, label in labels if name in found)
    return ": ".join(filter(None, (result.case, ", ".join(parts))))


def draw_cases(plan: Plan, results: Sequence[Assessment], folder: Path) -> None:
    """The figures of all cases together, into the run's folder."""
    enlist(folder, save_figures(run_figures(plan, results), folder / "plots"))


def run_figures(plan: Plan, results: Sequence[Assessment]) -> dict[str, Figure]:
    """Return the figure that the plan asks for, of all cases, as `cases`; and the trends of what it judges
    over what it sweeps or repeats, as `trend_MEASUREMENT`."""
    figures = {}
    if plan.figure not in ("none", "sweep"):
        figures["cases"] = draw_side_by_side(plan.figure, [panel_of(each) for each in results], plan.title)
    for name in trend_names(plan, results):
        asked = plan.figure == "sweep" and name == plan.figure_of
        figures["cases" if asked else f"trend_{name}"] = draw_trend(trend_of(plan, results, name), plan.title)
    return figures
