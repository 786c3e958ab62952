"""Figures of a run: one case alone, and all of them side by side."""

from __future__ import annotations

import math
from collections.abc import Sequence
from pathlib import Path

from matplotlib.figure import Figure

from benchtool.plan.cases import cases
from benchtool.plan.model import Plan
from benchtool.recording import enlist
from benchtool.report.figures.bode import draw_bode
from benchtool.report.figures.comparison import (
    Panel,
    draw_against,
    draw_spectra,
    draw_steady_traces,
    draw_torque_traces,
)
from benchtool.report.figures.steady_state import draw_steady_state, save_figures
from benchtool.report.figures.switching import draw_switching_states
from benchtool.results.assessment import Assessment

_SHOWN_S = 0.2  # of a steady state beside another


def draw_case(plan: Plan, result: Assessment) -> None:
    """Figures of one case, into its bundle."""
    enlist(result.bundle, save_figures(case_figures(plan, result), result.bundle / "plots"))


def case_figures(plan: Plan, result: Assessment) -> dict[str, Figure]:
    """Figures of one case by name."""
    panel = Panel(_label(result), result.capture, result.steady)
    figures = {}
    if plan.analyses.step and "torque" in result.capture.names:
        figures["torque"] = draw_torque_traces([panel], plan.title)
    elif result.steady is not None:
        figures |= draw_steady_state(result.capture, result.steady, result.transducer, title=plan.title)
    if result.bode is not None:
        figures["bode"] = draw_bode({_label(result): result.bode}, plan.title)
    for table in result.tables:
        if table.name == "switching_states":
            figures[table.name] = draw_switching_states(table, title=plan.title)
    return figures


def _label(result: Assessment) -> str:
    """Name of a case with what it comes to."""
    shown = {
        "torque_ripple_pp": "ripple",
        "reach_time": "reached in",
        "overshoot": "overshoot",
        "bandwidth_3dB": "bandwidth",
    }
    found = {each.name: each for each in result.measurements if math.isfinite(each.value)}
    parts = (
        f"{text} {found[name].value:.3g} {found[name].unit}" for name, text in shown.items() if name in found
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
    enlist(folder, save_figures(run_figures(plan, results), folder / "plots"))


def run_figures(plan: Plan, results: Sequence[Assessment]) -> dict[str, Figure]:
    """The figure that the plan asks for, of all cases, as `cases`; nothing if it asks for none."""
    panels = [Panel(_label(each), each.capture, each.steady) for each in results]
    match plan.figure:
        case "none":
            return {}
        case "torque":
            figure = draw_torque_traces(panels, plan.title)
        case "steady":
            figure = draw_steady_traces(panels, plan.title, _SHOWN_S)
        case "spectra":
            figure = draw_spectra(panels, plan.title)
        case "sweep":
            figure = _draw_sweep(plan, results)
        case "bode":
            found = {_label(each): each.bode for each in results if each.bode is not None}
            figure = draw_bode(found, plan.title)
    return {"cases": figure}
