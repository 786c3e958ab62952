"""Figures of a run: one case alone, and all of them side by side."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from benchtool.analysis.catalogue import catalogue
from benchtool.analysis.declaration import Panel
from benchtool.plan.model import Plan
from benchtool.recording import enlist
from benchtool.report.figures.comparison import draw_against
from benchtool.report.figures.drawings import draw_of_case, draw_side_by_side
from benchtool.report.figures.steady_state import save_figures
from benchtool.results.assessment import Assessment


def draw_case(plan: Plan, result: Assessment) -> None:
    """Figures of one case, into its bundle."""
    enlist(result.bundle, save_figures(case_figures(plan, result), result.bundle / "plots"))


def case_figures(plan: Plan, result: Assessment) -> dict[str, Figure]:
    """Figures of one case by name: those of every analysis that was made."""
    return draw_of_case(panel_of(result), plan.title)


def panel_of(result: Assessment, label: str = "") -> Panel:
    """A case as figures show it, by default labelled with what it comes to."""
    return Panel(
        label or _label(result),
        result.capture,
        result.steady,
        label or result.case,
        result.transducer,
        result.findings,
    )


def _label(result: Assessment) -> str:
    """Name of a case with what it comes to."""
    found = {each.name: each for each in result.measurements if math.isfinite(each.value)}
    labels = ((name, each.label) for each in catalogue().quantities for name in each.names if each.label)
    parts = (f"{label} {found[name].value:.3g} {found[name].unit}" for name, label in labels if name in found)
    return ": ".join(filter(None, (result.case, ", ".join(parts))))


def _draw_sweep(plan: Plan, results: Sequence[Assessment]) -> Figure:
    """The plan's measurement against the first part of the operating point that is swept."""
    swept = next(iter(plan.sweep.operating_point))
    series: dict[str, list[tuple[float, float]]] = {}
    unit = ""
    for result in results:
        x = float(result.coordinates.point[swept])
        law = result.coordinates.apart_from(swept) or plan.title
        for each in result.measurements:
            if each.name == plan.figure_of:
                unit = each.unit
                series.setdefault(law, []).append((x, each.value))
    return draw_against(series, plan.title, swept, f"{plan.figure_of} ({unit})")


def draw_cases(plan: Plan, results: Sequence[Assessment], folder: Path) -> None:
    """The figure that the plan asks for, of all cases, into the run's folder."""
    enlist(folder, save_figures(run_figures(plan, results), folder / "plots"))


def run_figures(plan: Plan, results: Sequence[Assessment]) -> dict[str, Figure]:
    """The figure that the plan asks for, of all cases, as `cases`; nothing if it asks for none."""
    match plan.figure:
        case "none":
            return {}
        case "sweep":
            return {"cases": _draw_sweep(plan, results)}
    return {"cases": draw_side_by_side(plan.figure, [panel_of(each) for each in results], plan.title)}
