"""Figures of a run: one case alone, and all of them side by side; as files beside what was recorded."""

from __future__ import annotations

import math
from collections import Counter
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Final

from matplotlib.figure import Figure

from benchtool.analysis import Panel, catalogue, raw
from benchtool.plan import Plan
from benchtool.recording import enlist, require_unchanged
from benchtool.report.assembly.recording import plan_of
from benchtool.report.assembly.trends import trend_names, trend_of
from benchtool.report.figures.drawings import draw_of_case, draw_side_by_side
from benchtool.report.figures.files import save_figures
from benchtool.report.figures.trend import draw_trend
from benchtool.results import Assessment, RecordedCase, RecordedRun

_PLOTS: Final = "plots"


def write_pictures(run: RecordedRun) -> tuple[Path, ...]:
    """Write the figures of a run as PNG, those of each case into its bundle, those of all cases together into
    the folder of the run; their paths. Earlier ones are replaced.

    Raises:
        RecordingError: a file cannot be written.
        PlugInError: an analysis of another package cannot draw its figure.
    """
    written: list[Path] = []
    in_bundle = Counter(case.bundle.directory for case in run.cases)
    for case in run.cases:
        place = case.bundle.directory
        regime = f"{case.name.replace(' ', '-')}-" if in_bundle[place] > 1 else ""
        written += _written(place, {f"{regime}{name}": each for name, each in case_figures(case).items()})
    results = [case.assessment for case in run.cases if case.assessment is not None]
    plan = plan_of(run.cases[0].bundle) if results else None
    if plan is not None and len(run.cases) > 1:
        written += _written(run.folder, run_figures(plan, results))
    return tuple(written)


def _written(folder: Path, figures: Mapping[str, Figure]) -> tuple[Path, ...]:
    require_unchanged(folder, [folder / _PLOTS])
    paths = save_figures(figures, folder / _PLOTS)
    enlist(folder, paths)
    return paths


def case_figures(case: RecordedCase, most: int | None = None) -> dict[str, Figure]:
    """Return figures of one case by name: those of every analysis that was made, or the first few of them."""
    if case.assessment is None:
        return {}
    plan = plan_of(case.bundle)
    return draw_of_case(panel_of(case.assessment), case.name if plan is None else plan.title, most)


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
    parts = (
        f"{label} {raw(found[name].value, 3)} {found[name].unit}" for name, label in labels if name in found
    )
    return ": ".join(filter(None, (result.case, ", ".join(parts))))


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
