"""The figures that analyses declare: those set by hand, by name, and those that an analysis draws itself."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from typing import Final

from matplotlib.figure import Figure

from benchtool.analysis import SteadyState
from benchtool.analysis.catalogue import catalogue
from benchtool.analysis.declaration import Analysis, Drawing, Panel
from benchtool.analysis.dynamics.bode import FREQUENCY_RESPONSE
from benchtool.analysis.plug_ins import guarded
from benchtool.analysis.switching import SWITCHING_STATES
from benchtool.document import Section
from benchtool.report.figures.bode import draw_bode
from benchtool.report.figures.comparison import draw_spectra, draw_steady_traces, draw_torque_traces
from benchtool.report.figures.steady_state import draw_current_spectrum, draw_flux_trajectory, draw_waveforms
from benchtool.report.figures.style import add_legend, dress, new_figure
from benchtool.report.figures.switching import draw_switching_states

_HEIGHT_IN = 4.4
_SHOWN_S = 0.2  # of a steady state beside another

Draw = Callable[[Sequence[Panel], str], Figure]


def _steady(panel: Panel) -> SteadyState:
    assert panel.steady is not None  # one of its analyses was made
    return panel.steady


def _waveforms(panels: Sequence[Panel], title: str) -> Figure:
    (panel,) = panels
    return draw_waveforms(panel.capture, _steady(panel), panel.transducer, title)


def _current_spectrum(panels: Sequence[Panel], title: str) -> Figure:
    (panel,) = panels
    return draw_current_spectrum(_steady(panel), title)


def _flux_trajectory(panels: Sequence[Panel], title: str) -> Figure:
    (panel,) = panels
    return draw_flux_trajectory(panel.capture, _steady(panel), title)


def _switching_states(panels: Sequence[Panel], title: str) -> Figure:
    (panel,) = panels
    (states,) = panel.findings[SWITCHING_STATES.name].tables
    return draw_switching_states(states, title=title)


def _steady_traces(panels: Sequence[Panel], title: str) -> Figure:
    return draw_steady_traces(panels, title, _SHOWN_S)


def _bode(panels: Sequence[Panel], title: str) -> Figure:
    return draw_bode({panel.label: panel.result(FREQUENCY_RESPONSE.name) for panel in panels}, title)


BY_HAND: Final[Mapping[str, Draw]] = {
    "waveforms": _waveforms,
    "current_spectrum": _current_spectrum,
    "flux_trajectory": _flux_trajectory,
    "switching_states": _switching_states,
    "bode": _bode,
    "torque": draw_torque_traces,
    "steady": _steady_traces,
    "spectra": draw_spectra,
}
"""By the name of the drawing."""


def draw(analysis: Analysis[Section], drawing: Drawing, panels: Sequence[Panel], title: str) -> Figure:
    """A figure of an analysis, of one case or of several.

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


def draw_of_case(panel: Panel, title: str) -> dict[str, Figure]:
    """The figures of one case by name: of every analysis that was made, as far as its channels go."""
    channels = frozenset(panel.capture.names)
    shown = {
        drawing.name: (analysis, drawing)
        for analysis in catalogue().analyses
        if analysis.name in panel.findings
        for drawing in analysis.figures
        if channels.issuperset(drawing.channels)
    }
    replaced = {name for _, drawing in shown.values() for name in drawing.replaces}
    return {
        name: draw(analysis, drawing, [panel], title)
        for name, (analysis, drawing) in shown.items()
        if name not in replaced
    }


def draw_side_by_side(name: str, panels: Sequence[Panel], title: str = "") -> Figure:
    """The figure of that name of several cases, under its own title by default; what it cannot show of them
    is left out."""
    drawing, declared = catalogue().comparisons[name]
    names = {each.name for each in declared}
    shown = [panel for panel in panels if drawing.of_recording or names & panel.findings.keys()]
    return draw(declared[0], drawing, shown, title or drawing.title)


def comparable(panels: Sequence[Panel]) -> tuple[str, ...]:
    """The names of the figures that show all of these cases side by side."""
    channels = frozenset.intersection(*(frozenset(panel.capture.names) for panel in panels))
    return tuple(
        name
        for name, (drawing, declared) in catalogue().comparisons.items()
        if channels.issuperset(drawing.channels)
        and any(all(each.name in panel.findings for panel in panels) for each in declared)
    )


def captions() -> dict[str, str]:
    """What the figures of analyses show, by name."""
    found = (each for one in catalogue().analyses for each in (*one.figures, *one.comparisons))
    return {drawing.name: drawing.caption for drawing in found}
