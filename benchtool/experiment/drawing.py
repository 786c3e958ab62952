"""Figures of a run: one case alone, and all of them side by side."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from benchtool.experiment.assessment import Assessment
from benchtool.experiment.cases import cases
from benchtool.experiment.plan import Plan
from benchtool.report import draw_steady_state, save_figures
from benchtool.report.comparison import (
    Panel,
    draw_against,
    draw_spectra,
    draw_steady_traces,
    draw_torque_traces,
)

_SHOWN_S = 0.2  # of a steady state beside another


def draw_case(plan: Plan, result: Assessment) -> None:
    """Figures of one case, into its bundle."""
    panel = Panel(_label(result), result.capture, result.steady)
    figures = {}
    if plan.analyses.step:
        figures["torque"] = draw_torque_traces([panel], plan.title)
    elif result.steady is not None:
        figures |= draw_steady_state(result.capture, result.steady, result.transducer, title=plan.title)
    save_figures(figures, result.bundle / "plots")


def _label(result: Assessment) -> str:
    """Name of a case with what it comes to."""
    shown = {"torque_ripple_pp": "ripple", "reach_time": "reached in", "overshoot": "overshoot"}
    found = {each.name: each for each in result.measurements if math.isfinite(each.value)}
    parts = (
        f"{text} {found[name].value:.2g} {found[name].unit}" for name, text in shown.items() if name in found
    )
    return ": ".join(filter(None, (result.case, ", ".join(parts))))


def _draw_sweep(plan: Plan, results: Sequence[Assessment]) -> Figure:
    """The plan's measurement against the first part of the operating point that is swept."""
    swept = next(iter(plan.sweep.operating_point), "load_torque_Nm")
    points = {each.name: each for each in cases(plan)}
    series: dict[str, list[tuple[float, float]]] = {}
    unit = ""
    for result in results:
        x = float(getattr(points[result.case].operating_point, swept))
        law = result.case.replace(f",{swept}={x:g}", "")
        for each in result.measurements:
            if each.name == plan.figure_of:
                unit = each.unit
                series.setdefault(law, []).append((x, each.value))
    return draw_against(series, plan.title, swept, f"{plan.figure_of} ({unit})")


def draw_cases(plan: Plan, results: Sequence[Assessment], folder: Path) -> None:
    """The figure that the plan asks for, of all cases, into the run's folder."""
    panels = [Panel(_label(each), each.capture, each.steady) for each in results]
    match plan.figure:
        case "none":
            return
        case "torque":
            figure = draw_torque_traces(panels, plan.title)
        case "steady":
            figure = draw_steady_traces(panels, plan.title, _SHOWN_S)
        case "spectra":
            figure = draw_spectra(panels, plan.title)
        case "sweep":
            figure = _draw_sweep(plan, results)
    save_figures({"cases": figure}, folder / "plots")
