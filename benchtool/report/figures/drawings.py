"""The figures that analyses declare: those set by hand, by name, and those that an analysis draws itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Any, Final

from matplotlib.figure import Figure

from benchtool.analysis import SWITCHING_STATES, Analysis, Drawing, Panel, catalogue, guarded
from benchtool.analysis.orders import SPEED_ORDERS, TORQUE_ORDERS
from benchtool.analysis.responses import FREQUENCY_RESPONSE
from benchtool.document import Section
from benchtool.report.figures.bode import draw_bode
from benchtool.report.figures.comparison import draw_spectra, draw_steady_traces, draw_torque_traces
from benchtool.report.figures.orders import draw_orders
from benchtool.report.figures.steady_state import draw_current_spectrum, draw_flux_trajectory
from benchtool.report.figures.style import add_legend, dress, new_figure
from benchtool.report.figures.switching import draw_switching_states
from benchtool.report.figures.waveforms import draw_waveforms

_HEIGHT_IN = 4.4

Draw = Callable[[Sequence[Panel], str], Figure]


def _waveforms(panels: Sequence[Panel], title: str) -> Figure:
    (panel,) = panels
    return draw_waveforms(panel, title)


def _current_spectrum(panels: Sequence[Panel], title: str) -> Figure:
    (panel,) = panels
    return draw_current_spectrum(panel, title)


def _flux_trajectory(panels: Sequence[Panel], title: str) -> Figure:
    (panel,) = panels
    return draw_flux_trajectory(panel, title)


def _switching_states(panels: Sequence[Panel], title: str) -> Figure:
    (panel,) = panels
    (states,) = panel.findings[SWITCHING_STATES.name].tables
    return draw_switching_states(states, title=title)


def _orders(name: str) -> Draw:
    """Return the figure of an analysis of orders."""

    def draw_one(panels: Sequence[Panel], title: str) -> Figure:
        (panel,) = panels
        return draw_orders(panel, name, title)

    return draw_one


def _bode(panels: Sequence[Panel], title: str) -> Figure:
    return draw_bode({panel.label: panel.result(FREQUENCY_RESPONSE.name) for panel in panels}, title)


BY_HAND: Final[Mapping[str, Draw]] = {
    "waveforms": _waveforms,
    "current_spectrum": _current_spectrum,
    "flux_trajectory": _flux_trajectory,
    "switching_states": _switching_states,
    "torque_orders": _orders(TORQUE_ORDERS.name),
    "speed_orders": _orders(SPEED_ORDERS.name),
    "bode": _bode,
    "torque": draw_torque_traces,
    "steady": draw_steady_traces,
    "spectra": draw_spectra,
}
"""By the name of the drawing."""


def draw(analysis: Analysis[Section], drawing: Drawing, panels: Sequence[Panel], title: str) -> Figure:
    """Return a figure of an analysis, of one case or of several.

    Raises:
        AnalysisError: a capture has not what it shows.
        PlugInError: the analysis is of another package, and cannot draw it.
    """
    if drawing.draw is None:
        return BY_HAND[drawing.name](panels, title)
    figure = new_figure(_HEIGHT_IN, title, "")
    with guarded(analysis, f"draw '{drawing.name}'"):
        drawing.draw(figure, panels)
    for axes in figure.axes:
        dress(axes, axes.get_xlabel(), axes.get_ylabel())
        if axes.get_legend() is None and axes.get_legend_handles_labels()[1]:
            add_legend(axes)
    return figure


def figure_names(panel: Panel) -> tuple[str, ...]:
    """Return the names of the figures of one case."""
    return tuple(drawing.name for _, drawing in _of_case(panel))


def draw_of_case(panel: Panel, title: str, most: int | None = None) -> dict[str, Figure]:
    """Return the figures of one case by name: of every analysis that was made, as far as its channels go; or
    the first few of them."""
    shown = _of_case(panel)[:most]
    return {drawing.name: draw(analysis, drawing, [panel], title) for analysis, drawing in shown}


def _found(panel: Panel, analysis: str) -> bool:
    """Return whether an analysis found anything; of a window that is too short, say, it may not."""
    found = panel.findings.get(analysis)
    return found is not None and bool(found.measurements or found.tables or found.result is not None)


def _of_case(panel: Panel) -> list[tuple[Analysis[Any], Drawing]]:
    channels = frozenset(panel.capture.names)
    shown = {
        drawing.name: (analysis, drawing)
        for analysis in catalogue().analyses
        if _found(panel, analysis.name)
        for drawing in analysis.figures
        if channels.issuperset(drawing.channels)
    }
    replaced = {name for _, drawing in shown.values() for name in drawing.replaces}
    return [each for name, each in shown.items() if name not in replaced]


def draw_side_by_side(name: str, panels: Sequence[Panel], title: str = "") -> Figure:
    """Return the figure of that name of several cases, under its own title by default; what it cannot show of
    them is left out."""
    drawing, declared = catalogue().comparisons[name]
    names = {each.name for each in declared}
    shown = [panel for panel in panels if drawing.of_recording or names & panel.findings.keys()]
    return draw(declared[0], drawing, shown, title or drawing.title)


def comparable(panels: Sequence[Panel]) -> tuple[str, ...]:
    """Return the names of the figures that show all of these cases side by side."""
    channels = frozenset.intersection(*(frozenset(panel.capture.names) for panel in panels))
    return tuple(
        name
        for name, (drawing, declared) in catalogue().comparisons.items()
        if channels.issuperset(drawing.channels)
        and any(all(each.name in panel.findings for panel in panels) for each in declared)
    )


def captions() -> dict[str, str]:
    """Return what the figures of analyses show, by name."""
    found = (each for one in catalogue().analyses for each in (*one.figures, *one.comparisons))
    return {drawing.name: drawing.caption for drawing in found}
